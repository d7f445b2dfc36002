#include "core/paths/edge_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "core/base/vec3.h"
#include "core/field/field.h"

namespace geodesic {
namespace {

// Where the way to a vertex came from: `first` is the vertex before it, kNone at a
// corner of the source's face; `second` is the face that both are in.
using Before = Parents;

class EdgePath {
 public:
  // `edges`: the mesh's own, or those of its Delaunay triangulation.
  EdgePath(const Adjacency& adjacency, const Triangulation& edges, const SurfacePoint& from,
           const SurfacePoint& to, WavefrontScratch& scratch)
      : adjacency_(adjacency),
        edges_(edges),
        positions_(adjacency.mesh().positions()),
        from_(from),
        to_(to),
        start_(position_of(adjacency.mesh(), from)),
        goal_(position_of(adjacency.mesh(), to)),
        heap_(scratch.heap),
        distance_(scratch.distance),
        before_(scratch.parents) {
    heap_.reset(positions_.size());
    distance_.assign(positions_.size(), kUnreached);
    before_.resize(positions_.size());
  }

  // The path, of the mesh's own edges.
  Result<std::optional<Path>> find(const Cancel& cancel) {
    const auto length = find_length(cancel);
    if (!length) return fail(length.error());
    if (!*length) return std::nullopt;
    return assemble();
  }

  // A vertex comes out of the heap once, and each face at it is looked at once then.
  Result<std::optional<double>> find_length(const Cancel& cancel) {
    Poll poll(cancel);
    list_ends(poll);
    start(poll);
    while (!poll.stopped() && !heap_.empty() && heap_.least().key < length_) {
      const std::uint32_t v = heap_.pop().vertex;
      arrive_from(v);
      spread_from(v, poll);
    }
    if (poll.stopped()) return fail_stopped(cancel);
    if (length_ == kUnreached) return std::nullopt;
    return length_;
  }

 private:
  // The faces that the target lies in, which may be many, by their corners.
  void list_ends(Poll& poll) {
    for (const SurfacePoint& end : in_all_faces(adjacency_, to_)) {
      if (poll.cancelled()) return;
      end_faces_.insert(end.face);
      for (const std::uint32_t v : adjacency_.face(end.face).vertex)
        face_to_end_.emplace(v, end.face);
    }
  }

  void start(Poll& poll) {
    if (from_.at_vertex()) lower(from_.vertex, 0, {kNone, kNone});
    if (from_.at_vertex() && to_.at_vertex() && from_.vertex == to_.vertex) length_ = 0;
    for (const SurfacePoint& place : in_all_faces(adjacency_, from_)) {
      if (poll.cancelled()) return;
      if (!from_.at_vertex()) {
        for (const std::uint32_t v : adjacency_.face(place.face).vertex) {
          lower(v, geodesic::distance(start_, positions_[v]), {kNone, place.face});
        }
      }
      if (!end_faces_.contains(place.face)) continue;
      // kNone, unless it is a vertex
      arrive({from_.vertex, place.face}, geodesic::distance(start_, goal_));
    }
  }

  void spread_from(std::uint32_t v, Poll& poll) {
    if (poll.cancelled()) return;
    for (const std::uint32_t corner : edges_.corners(v)) {
      if (poll.cancelled()) return;
      const FaceRecord& face = edges_.faces[face_of(corner)];
      const std::uint32_t c = corner_of(corner);
      const std::uint32_t behind = previous_corner(c);
      spread_along(v, corner, face.vertex[next_corner(c)], face.length2(c));
      // Else it is the next one in the face beyond.
      if (edges_.is_oriented && face.ring[behind] != halfedge(face_of(corner), behind)) continue;
      spread_along(v, corner, face.vertex[behind], face.length2(behind));
    }
  }

  void spread_along(std::uint32_t v, std::uint32_t corner, std::uint32_t w, double length2) {
    if (heap_.accepted(w)) return;
    // Else rounding may leave nothing of a face's short side. Of an edge that is not the mesh's own
    // it is less than the length, and what is looked for is only a guess.
    const double length = edges_.is_even ? std::sqrt(std::max(length2, 0.0))
                                         : geodesic::distance(positions_[v], positions_[w]);
    lower(w, distance_[v] + length, {v, face_of(corner)});
  }

  void arrive_from(std::uint32_t v) {
    const auto end = face_to_end_.find(v);
    if (end == face_to_end_.end()) return;
    arrive({v, end->second}, distance_[v] + geodesic::distance(positions_[v], goal_));
  }

  void arrive(Before before, double length) {
    if (!(length < length_)) return;
    length_ = length;
    last_ = before;
  }

  void lower(std::uint32_t v, double distance, Before before) {
    if (!(distance < distance_[v])) return;
    distance_[v] = distance;
    before_[v] = before;
    heap_.push_or_lower(v, distance + kWeightOfTheRest * geodesic::distance(positions_[v], goal_));
  }

  // The vertex as a corner of a face that it is in.
  [[nodiscard]] PathPoint corner_point(std::uint32_t v, std::uint32_t face) const {
    const auto& corners = adjacency_.face(face).vertex;
    SurfacePoint point{face, {0, 0, 0}, v};
    const auto c = std::find(corners.begin(), corners.end(), v) - corners.begin();
    point.bary[static_cast<std::size_t>(c)] = 1;
    return {point, positions_[v]};
  }

  // An end of the path as it is in that face.
  [[nodiscard]] PathPoint end_point(const SurfacePoint& end, Vec3 position,
                                    std::uint32_t face) const {
    for (const SurfacePoint& place : in_all_faces(adjacency_, end)) {
      if (place.face == face) return {place, position};
    }
    return {end, position};
  }

  [[nodiscard]] Path assemble() const {
    Path path;
    path.points.push_back(end_point(to_, goal_, last_.second));
    Before before = last_;
    // The end at a vertex is one of the ways' own vertices.
    if (to_.at_vertex() && before.first == to_.vertex) before = before_[to_.vertex];
    if (before.second != kNone) path.points.back() = end_point(to_, goal_, before.second);
    while (before.first != kNone) {
      const std::uint32_t v = before.first;
      path.points.push_back(corner_point(v, before.second));
      before = before_[v];
    }
    if (!from_.at_vertex() && before.second != kNone) {
      path.points.push_back(end_point(from_, start_, before.second));
    }
    std::reverse(path.points.begin(), path.points.end());
    for (std::size_t i = 1; i < path.points.size(); ++i) {
      path.length += geodesic::distance(path.points[i - 1].position, path.points[i].position);
    }
    return path;
  }

  const Adjacency& adjacency_;
  const Triangulation edges_;
  std::span<const Vec3> positions_;
  const SurfacePoint& from_;
  const SurfacePoint& to_;
  const Vec3 start_;
  const Vec3 goal_;
  VertexHeap& heap_;
  std::vector<double>& distance_;
  std::vector<Before>& before_;
  double length_ = kUnreached;                   // of the shortest whole way so far
  Before last_;                                  // from where it comes to the target
  std::unordered_set<std::uint32_t> end_faces_;  // that the target lies in
  // From each corner of those faces, the first of them.
  std::unordered_map<std::uint32_t, std::uint32_t> face_to_end_;
};

}  // namespace

Result<std::optional<Path>> edge_path(const Adjacency& adjacency, const SurfacePoint& from,
                                      const SurfacePoint& to, WavefrontScratch& scratch,
                                      const Cancel& cancel) {
  return EdgePath(adjacency, adjacency.triangulation(), from, to, scratch).find(cancel);
}

Result<std::optional<double>> delaunay_edge_distance(const Adjacency& adjacency,
                                                     const SurfacePoint& from,
                                                     const SurfacePoint& to,
                                                     WavefrontScratch& scratch,
                                                     const Cancel& cancel) {
  return EdgePath(adjacency, adjacency.delaunay(), from, to, scratch).find_length(cancel);
}

}  // namespace geodesic
