#include "core/exact_pair.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/arrive_at_point.h"
#include "core/longest_edge.h"
#include "core/trace_path.h"

namespace geodesic {
namespace {

// A path this part longer than the distance is not the shortest one.
constexpr double kLonger = 1e-9;

// So many rings of faces round the traced path have their windows kept, first and last.
constexpr std::uint32_t kRings = 2;
constexpr std::uint32_t kMostRings = 12;

// A field takes about as long as the next one.
constexpr double kFirstField = 0.5;

// Faces, each once.
class FaceSet {
 public:
  explicit FaceSet(std::size_t face_count) : has_(face_count, false) {}

  void add(std::uint32_t f) {
    if (has_[f]) return;
    has_[f] = true;
    faces_.push_back(f);
  }
  // All faces that share a vertex with one of these.
  void grow(const Adjacency& adjacency) {
    for (std::size_t i = 0, count = faces_.size(); i < count; ++i) {
      const auto vertices = adjacency.face(faces_[i]).vertex;
      for (const std::uint32_t v : vertices) {
        for (const std::uint32_t corner : adjacency.corners(v)) add(face_of(corner));
      }
    }
  }
  [[nodiscard]] const std::vector<std::uint32_t>& faces() const { return faces_; }

 private:
  std::vector<bool> has_;
  std::vector<std::uint32_t> faces_;
};

FaceSet faces_about(const Adjacency& adjacency, const SurfacePoint& point) {
  FaceSet faces(adjacency.faces().size());
  for (const SurfacePoint& place : in_all_faces(adjacency, point)) faces.add(place.face);
  return faces;
}

FaceSet faces_along(const Adjacency& adjacency, const Path& path) {
  FaceSet faces(adjacency.faces().size());
  for (const PathPoint& at : path.points) {
    for (const SurfacePoint& place : in_all_faces(adjacency, at.point)) faces.add(place.face);
  }
  return faces;
}

class ExactPair {
 public:
  ExactPair(const Adjacency& adjacency, const Source& from, const SurfacePoint& to,
            ExactScratch& scratch)
      : adjacency_(adjacency), from_(from), to_(to), scratch_(scratch) {
    // Those of its faces, which are reached by the path at the latest.
    const FaceSet about = faces_about(adjacency, to);
    for (const std::uint32_t f : about.faces()) {
      const auto vertices = adjacency.face(f).vertex;
      targets_.insert(targets_.end(), vertices.begin(), vertices.end());
    }
    if (to.at_vertex()) {
      targets_.push_back(to.vertex);
    } else {
      beyond_targets_ = longest_edge_of(adjacency, about.faces());
    }
  }

  // With the windows of these faces.
  Result<Field> field(const FaceSet& details, const Cancel& cancel) {
    FieldLimits limits;
    limits.targets = targets_;
    limits.beyond_targets = beyond_targets_;
    limits.keep_details = true;
    limits.detail_faces = details.faces();
    return exact_field(adjacency_, {&from_, 1}, limits, scratch_, cancel);
  }

  // About where the path is.
  Result<std::optional<Path>> rough_path(Field field, const Cancel& cancel) {
    field.windows.reset();
    field.method = Method::back_traced;  // by distances alone
    return trace_path(adjacency_, field, to_, cancel);
  }

 private:
  const Adjacency& adjacency_;
  const Source& from_;
  const SurfacePoint& to_;
  ExactScratch& scratch_;
  std::vector<std::uint32_t> targets_;
  double beyond_targets_ = 0;
};

}  // namespace

Result<Pair> exact_pair(const Adjacency& adjacency, const Source& from, const SurfacePoint& to,
                        bool with_path, ExactScratch& scratch, const Cancel& cancel) {
  ExactPair search(adjacency, from, to, scratch);
  const FaceSet at_target = faces_about(adjacency, to);
  auto field = search.field(at_target, with_path ? cancel.part(0, kFirstField) : cancel);
  if (!field) return fail(std::move(field.error()));
  Pair pair;
  pair.distance = PointArrivals(adjacency, *field).distance_at(to);
  if (!with_path || pair.distance == kUnreached) return pair;
  const auto rough = search.rough_path(std::move(*field), cancel);
  if (!rough) return fail(rough.error());
  if (!*rough) return pair;
  FaceSet faces = faces_along(adjacency, **rough);
  for (std::uint32_t rings = 0, wanted = kRings; wanted <= kMostRings;
       wanted += kMostRings - kRings) {
    for (; rings < wanted; ++rings) faces.grow(adjacency);
    const auto near = search.field(faces, cancel.part(kFirstField, 1));
    if (!near) return fail(near.error());
    auto path = trace_path(adjacency, *near, to, cancel);
    if (!path) return fail(std::move(path.error()));
    if (*path && from.offset + (*path)->length <= pair.distance * (1 + kLonger)) {
      pair.path = std::move(*path);
      return pair;
    }
  }
  return fail(ErrorCode::too_much_memory,
              "the shortest path cannot be found without the windows of the whole surface, which "
              "take too much memory: auto takes little");
}

}  // namespace geodesic
