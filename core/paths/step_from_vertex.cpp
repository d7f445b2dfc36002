// The steps back from a vertex: by its parents or, where a method has none, through whichever face
// is best; and the steps that are left where those lead nowhere, to a vertex of a lesser distance.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/paths/arrive_at_point.h"
#include "core/paths/step_in_face.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "core/wavefront/fast_marching.h"

namespace geodesic {

StepBack PointArrivals::through_faces_at(std::uint32_t vertex) const {
  StepBack best;
  for (const SurfacePoint& place : in_all_faces(adjacency_, point_at_vertex(adjacency_, vertex))) {
    if (stopped()) return best;
    const StepBack step = through_face(place);
    if (is_better(step, best)) best = step;
  }
  if (best.to != StepBack::To::nowhere || !adjacency_.corners(vertex).empty()) return best;
  // An isolated vertex: nothing but a source there can have reached it.
  return straight_from_source(vertex,
                              field_.nearest_source.empty() ? 0 : field_.nearest_source[vertex]);
}

StepBack PointArrivals::by_parents(std::uint32_t vertex) const {
  if (!traits_of(field_.method).has_parents) return through_faces_at(vertex);
  const Parents parents = field_.parents[vertex];
  if (parents.from_source()) return straight_from_source(vertex, parents.second);
  if (parents.along_edge()) {
    const Halfedge h = adjacency_.find_edge(vertex, parents.first);
    const FaceRecord& face = adjacency_.face(face_of(h));
    const std::uint32_t c = corner_of(h);
    const std::uint32_t n = next_corner(c);
    const bool forward = face.vertex[c] == vertex;
    return to_vertex(face, face_of(h), forward ? n : c, weights_at_corner(forward ? c : n),
                     field_.distance[vertex]);
  }
  for (const std::uint32_t corner : adjacency_.corners(vertex)) {
    const std::uint32_t f = face_of(corner);
    const std::uint32_t side = next_corner(corner_of(corner));
    const FaceRecord& face = adjacency_.face(f);
    if (face.vertex[side] != parents.first && face.vertex[side] != parents.second) continue;
    const std::uint32_t other = face.vertex[next_corner(side)];
    if (other != parents.first && other != parents.second) continue;
    const Arrival arrival = over_base(face.vertex[side], other, face.apex_over(side));
    return over_side(face, f, side, weights_at_corner(corner_of(corner)), arrival);
  }
  return {};
}

std::vector<StepBack> PointArrivals::to_lesser_vertex(std::uint32_t vertex) const {
  StepBack best;
  std::vector<StepBack> steps;
  for (const std::uint32_t corner : adjacency_.corners(vertex)) {
    if (stopped()) return {};
    const std::uint32_t f = face_of(corner);
    const std::uint32_t c = corner_of(corner);
    const FaceRecord& face = adjacency_.face(f);
    for (const std::uint32_t end : {next_corner(c), previous_corner(c)}) {
      const double d = field_.distance[face.vertex[end]];
      if (!(d < field_.distance[vertex])) continue;
      const double along =
          d + std::sqrt(std::max(face.length2(end == next_corner(c) ? c : end), 0.0));
      if (!(along < best.distance)) continue;
      best = to_vertex(face, f, end, weights_at_corner(c), along);
      steps = {best};
    }
    if (!(face.dot[c] < 0)) continue;
    const ObtuseSplit split = split_obtuse(adjacency_, f, c);
    if (split.far == kNone || !(field_.distance[split.far] < field_.distance[vertex])) continue;
    const double along = field_.distance[split.far] + std::hypot(split.far_at[0], split.far_at[1]);
    if (!(along < best.distance)) continue;
    best.distance = along;
    steps.clear();
    for (const FaceSegment& segment : virtual_edge(adjacency_, f, c)) {
      StepBack& step = steps.emplace_back();
      step.to = StepBack::To::edge;
      step.distance = along;
      step.face = segment.face;
      step.start = segment.from;
      step.bary = segment.to;
    }
    steps.back().to = StepBack::To::vertex;
    steps.back().vertex = split.far;
  }
  return steps;
}

StepBack PointArrivals::to_end_of_side(std::uint32_t f, std::uint32_t c,
                                       const std::array<double, 3>& start) const {
  const Sides2 side2 = sides_of(adjacency_, f);
  const FaceRecord& face = adjacency_.face(f);
  const auto by = [&](std::uint32_t corner) {
    return field_.distance[face.vertex[corner]] +
           std::sqrt(squared_distance(side2, start, weights_at_corner(corner)));
  };
  const std::uint32_t n = next_corner(c);
  const double by_first = by(c);
  const double by_second = by(n);
  return by_first <= by_second ? to_vertex(face, f, c, start, by_first)
                               : to_vertex(face, f, n, start, by_second);
}

StepBack PointArrivals::straight_from_source(std::uint32_t vertex, std::uint32_t source) const {
  StepBack step;
  step.to = StepBack::To::source;
  step.distance = field_.distance[vertex];
  step.source = source;
  for (const SourcePlace& place : source_places_) {
    if (place.source != source) continue;
    const FaceRecord& face = adjacency_.face(place.face);
    for (std::uint32_t c = 0; c < 3; ++c) {
      if (face.vertex[c] != vertex) continue;
      step.face = place.face;
      step.start = weights_at_corner(c);
      step.bary = place.bary;
      return step;
    }
  }
  // A vertex that a line has made a source of is in none of these places, but beside this one.
  const std::uint32_t at = field_.sources[source].point.vertex;
  if (at == vertex || at == kNone) return step;  // an isolated vertex that is its own source
  for (const std::uint32_t corner : adjacency_.corners(vertex)) {
    if (stopped()) break;
    const FaceRecord& face = adjacency_.face(face_of(corner));
    for (std::uint32_t c = 0; c < 3; ++c) {
      if (face.vertex[c] != at) continue;
      return to_vertex(face, face_of(corner), c, weights_at_corner(corner_of(corner)),
                       step.distance);
    }
  }
  return step;
}

}  // namespace geodesic
