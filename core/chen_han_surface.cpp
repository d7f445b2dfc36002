// What the propagation of Chen and Han's windows has to know of a surface beforehand:
// where paths may bend, which faces repeat others, where sources lie.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <tuple>

#include "core/chen_han_front.h"
#include "core/polled_fill.h"
#include "core/polled_sort.h"

namespace geodesic::chen_han {
namespace {

// A vertex whose angles add up to more than 2 pi by this part is a saddle. Less is
// rounding: on a flat grid no vertex is one.
constexpr double kSaddle = 1e-12;

// Whether a face is so thin, or one of its sides so short, that rounding decides by which side of
// a corner a ray goes past it. Paths may bend at its corners then, whatever the angles there.
bool is_thin(const FaceRecord& face) {
  return !(face.area2 > kThin * face.length2(face.longest_side()));
}

}  // namespace

Front::Front(const Adjacency& adjacency, Field& field, const FieldLimits& limits,
             ChenHanScratch& scratch, Poll& poll)
    : adjacency_(adjacency),
      field_(field),
      distance_(field.distance.doubles()),
      limits_(limits),
      scratch_(scratch),
      poll_(poll),
      lit_(poll.memory()) {
  const std::size_t face_count = adjacency.mesh().face_count();
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  scratch.queue.clear();
  polled_assign(scratch.occupier, 4 * face_count, {kUnreached, 0}, poll);
  scratch.bends.assign(vertex_count, 0);
  scratch.waiting.assign(vertex_count, kUnreached);
  scratch.source_in_face.clear();
  scratch.places.clear();
  scratch.same_as.clear();
  if (poll.ask()) return;
  mark_faces_with_sources();
  if (adjacency.report().faces_duplicate > 0) mark_duplicate_faces();
  see_all_ = needs_seen_windows();
  if (see_all_) scratch.seen.reset(adjacency, poll);
}

void Front::mark_faces_with_sources() {
  for (std::uint32_t s = 0; s < field_.sources.size(); ++s) {
    if (field_.sources[s].point.at_vertex()) continue;
    scratch_.source_in_face.resize(adjacency_.mesh().face_count(), 0);
    for (const SurfacePoint& place : in_all_faces(adjacency_, field_.sources[s].point)) {
      scratch_.source_in_face[place.face] = 1;
      scratch_.places.push_back({place.face, s, place.bary});
    }
  }
  std::sort(scratch_.places.begin(), scratch_.places.end(),
            [](const auto& a, const auto& b) { return a.face < b.face; });
}

// Whatever passes through a face may as well pass through another one with the same
// corners. So only the first of them takes part, besides those with a source inside.
void Front::mark_duplicate_faces() {
  const auto faces = adjacency_.faces();
  struct Corners {
    Triangle sorted;
    std::uint32_t face;
    bool operator<(const Corners& other) const {
      return std::tie(sorted, face) < std::tie(other.sorted, other.face);
    }
  };
  std::vector<Corners> all;
  std::vector<Corners> spare;
  polled_assign(scratch_.same_as, faces.size(), std::uint32_t{0}, poll_);
  all.reserve(faces.size());
  for (std::uint32_t f = 0; f < scratch_.same_as.size() && !poll_.cancelled(); ++f) {
    scratch_.same_as[f] = f;
    const bool has_source = !scratch_.source_in_face.empty() && scratch_.source_in_face[f] != 0;
    if (has_source) continue;
    Triangle sorted = faces[f].vertex;
    std::sort(sorted.begin(), sorted.end());
    all.push_back({sorted, f});
  }
  polled_sort(all, 0, all.size(), std::less<>(), spare, poll_);
  for (std::size_t i = 1; i < all.size() && !poll_.cancelled(); ++i) {
    if (all[i].sorted == all[i - 1].sorted) {
      scratch_.same_as[all[i].face] = scratch_.same_as[all[i - 1].face];
    }
  }
}

bool Front::needs_seen_windows() const {
  if (adjacency_.report().edges_non_manifold > 0) return true;
  const auto faces = adjacency_.faces();
  return std::any_of(faces.begin(), faces.end(), has_no_area);
}

bool Front::bends(std::uint32_t vertex) {
  std::uint8_t& known = scratch_.bends[vertex];
  if (known == 0) known = bends_by_its_faces(vertex) ? 2 : 1;
  return known == 2;
}

bool Front::bends_by_its_faces(std::uint32_t vertex) const {
  if (adjacency_.is_pinched(vertex)) return true;
  double angles = 0;
  for (const std::uint32_t corner : adjacency_.corners(vertex)) {
    if (poll_.cancelled()) return true;
    if (skipped(face_of(corner))) continue;
    const FaceRecord& face = adjacency_.face(face_of(corner));
    const std::uint32_t c = corner_of(corner);
    if (is_thin(face)) return true;
    angles += std::atan2(face.area2, face.dot[c]);
    for (const Halfedge side : {corner, halfedge(face_of(corner), previous_corner(c))}) {
      std::uint32_t across = 0;
      for (Halfedge h = adjacency_.ring(side); h != side; h = adjacency_.ring(h)) {
        if (poll_.cancelled()) return true;
        if (!skipped(face_of(h))) ++across;
      }
      if (across != 1) return true;
    }
  }
  return angles > 2 * std::numbers::pi * (1 + kSaddle);
}

}  // namespace geodesic::chen_han
