// What the propagation of Chen and Han's windows has to know of a surface beforehand:
// where paths may bend, which faces repeat others, where sources lie.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/polled_fill.h"
#include "core/base/polled_sort.h"
#include "core/base/tolerances.h"
#include "core/chen_han/front.h"
#include "core/surface/copied_faces.h"
#include "core/surface/walk_over_faces.h"

namespace geodesic::chen_han {
namespace {

// Whether a face is so thin, or one of its sides so short, that rounding decides by which side of
// a corner a ray goes past it. Paths may bend at its corners then, whatever the angles there.
bool is_thin(const FaceRecord& face) {
  return !(face.area2 > tolerance::kThin * face.length2(face.longest_side()));
}

// What ChenHanScratch::source_in_face says of a face.
constexpr std::uint8_t kSourceOnSide = 1;
constexpr std::uint8_t kSourceInside = 2;

bool is_inside(const SurfacePoint& place) {
  return place.bary[0] != 0 && place.bary[1] != 0 && place.bary[2] != 0;
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
      intervals_(poll.memory()) {
  const std::size_t face_count = adjacency.mesh().face_count();
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  scratch.queue.clear();
  polled_assign(scratch.occupier, 4 * face_count, {kUnreached, 0}, poll);
  scratch.bends.assign(vertex_count, 0);
  scratch.waiting.assign(vertex_count, kUnreached);
  scratch.source_in_face.clear();
  scratch.places.clear();
  scratch.same_as.clear();
  taking_part_ = static_cast<std::uint32_t>(face_count);
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
      if (poll_.cancelled()) return;
      auto& mark = scratch_.source_in_face[place.face];
      mark = std::max(mark, is_inside(place) ? kSourceInside : kSourceOnSide);
      scratch_.places.push_back({place.face, s, place.bary});
    }
  }
  std::vector<ChenHanScratch::Place> spare;
  const auto earlier = [](const auto& a, const auto& b) { return a.face < b.face; };
  polled_sort(scratch_.places, 0, scratch_.places.size(), earlier, spare, poll_);
}

// Whatever passes through a face may as well pass through another one with the same
// corners. So only the first of them takes part, besides those with a source inside; one on a
// side is in all of them.
void Front::mark_duplicate_faces() {
  auto& same_as = scratch_.same_as;
  polled_assign(same_as, adjacency_.faces().size(), kNone, poll_);
  for (std::uint32_t f = 0; f < same_as.size() && !poll_.cancelled(); ++f) {
    const bool has_source =
        !scratch_.source_in_face.empty() && scratch_.source_in_face[f] == kSourceInside;
    if (!has_source && same_as[f] == kNone) same_as[f] = f;
    if (has_later_copy(adjacency_, f)) same_as[later_copy(adjacency_, f)] = same_as[f];
    if (has_source) same_as[f] = f;
  }
  link_participating_faces();
}

// Thousands of others may lie between two of them on an edge.
void Front::link_participating_faces() {
  polled_assign(ring_, 4 * adjacency_.faces().size(), kNone, poll_);
  for (std::uint32_t f = 0; f < adjacency_.faces().size() && !poll_.cancelled(); ++f) {
    if (skipped(f)) {
      --taking_part_;
      continue;
    }
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      Halfedge next = adjacency_.ring(h);
      while (next != h && skipped(face_of(next)) && !poll_.cancelled()) {
        next = adjacency_.ring(next);
      }
      ring_[h] = next;
    }
  }
}

bool Front::needs_seen_windows() const {
  if (adjacency_.report().edges_non_manifold > 0) return true;
  const auto faces = adjacency_.faces();
  return std::any_of(faces.begin(), faces.end(), [&](const FaceRecord& face) {
    return poll_.cancelled() || has_no_area(face);
  });
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
    angles += corner_angle(face, c);
    for (const Halfedge side : {corner, halfedge(face_of(corner), previous_corner(c))}) {
      // In one other face, neither more nor fewer.
      if (next_around(side) == side || next_around(next_around(side)) != side) return true;
    }
  }
  return angles > 2 * std::numbers::pi * (1 + tolerance::kSaddle);
}

}  // namespace geodesic::chen_han
