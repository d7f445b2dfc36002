#include "core/arrive_at_point.h"

#include <algorithm>
#include <cmath>

#include "core/novotni.h"
#include "core/virtual_source.h"

namespace geodesic {
namespace {

using Weights = std::array<double, 3>;

Weights weights_at_corner(std::uint32_t corner) {
  Weights bary{0, 0, 0};
  bary[corner] = 1;
  return bary;
}

// A crossing closer to an end of its edge than this part of the edge is that end:
// the face across would see nothing of the surface on the vertex's other side.
constexpr double kAtEnd = 1e-9;

// Squared distance between two points of a face; differences of weights add up to
// zero, so |sum u_i x_i|^2 = -sum over sides u_i u_j |x_i - x_j|^2.
double squared_distance(const FaceRecord& face, const Weights& a, const Weights& b) {
  double sum = 0;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const std::uint32_t n = next_corner(c);
    sum -= (a[c] - b[c]) * (a[n] - b[n]) * face.length2(c);
  }
  return std::max(sum, 0.0);
}

// The point as an apex over the side that starts at corner c.
UnfoldedApex apex_at(const FaceRecord& face, std::uint32_t c, const Weights& bary) {
  const std::uint32_t n = next_corner(c);
  const double above = bary[previous_corner(c)];
  const double base2 = face.length2(c);
  return {bary[n] * base2 + above * face.dot[c], bary[c] * base2 + above * face.dot[n],
          above * face.area2, squared_distance(face, bary, weights_at_corner(c)),
          squared_distance(face, bary, weights_at_corner(n))};
}

StepBack to_vertex(const FaceRecord& face, std::uint32_t f, std::uint32_t corner,
                   const Weights& start, double distance) {
  StepBack step;
  step.to = StepBack::To::vertex;
  step.distance = distance;
  step.face = f;
  step.start = start;
  step.bary = weights_at_corner(corner);
  step.vertex = face.vertex[corner];
  return step;
}

// The step that case (a), (b) or (c) of the paper's Fig. 4 asks for.
StepBack over_side(const FaceRecord& face, std::uint32_t f, std::uint32_t c, const Weights& start,
                   const Arrival& arrival) {
  const std::uint32_t n = next_corner(c);
  if (arrival.which == Fig4::b || arrival.crossing < kAtEnd) {
    return to_vertex(face, f, c, start, arrival.distance);
  }
  if (arrival.which == Fig4::c || arrival.crossing > 1 - kAtEnd) {
    return to_vertex(face, f, n, start, arrival.distance);
  }
  StepBack step;
  step.to = StepBack::To::edge;
  step.distance = arrival.distance;
  step.face = f;
  step.start = start;
  step.bary[c] = 1 - arrival.crossing;
  step.bary[n] = arrival.crossing;
  step.base = halfedge(f, c);
  return step;
}

}  // namespace

PointArrivals::PointArrivals(const Adjacency& adjacency, const Field& field)
    : adjacency_(adjacency), field_(field) {
  for (std::uint32_t s = 0; s < field.sources.size(); ++s) {
    for (const SurfacePoint& place : in_all_faces(adjacency, field.sources[s].point)) {
      source_places_.push_back({place.face, s, place.bary});
    }
  }
  std::stable_sort(source_places_.begin(), source_places_.end(),
                   [](const SourcePlace& a, const SourcePlace& b) { return a.face < b.face; });
}

// The method's own rule for a third vertex.
Arrival PointArrivals::over_base(std::uint32_t p, std::uint32_t q, const UnfoldedApex& apex) const {
  const double dp = field_.distance[p];
  const double dq = field_.distance[q];
  if (!field_.same_source(p, q)) return arrive_along_sides(dp, dq, apex);
  switch (field_.method) {
    case Method::dijkstra:
      return arrive_along_sides(dp, dq, apex);
    case Method::novotni:
      return arrive_without_cases(dp, dq, apex);
    default:
      return arrive(dp, dq, apex);
  }
}

StepBack PointArrivals::through_face(const SurfacePoint& place) const {
  const FaceRecord& face = adjacency_.face(place.face);
  StepBack best;
  const auto first =
      std::lower_bound(source_places_.begin(), source_places_.end(), place.face,
                       [](const SourcePlace& source, std::uint32_t f) { return source.face < f; });
  for (auto it = first; it != source_places_.end() && it->face == place.face; ++it) {
    const double d =
        field_.sources[it->source].offset + std::sqrt(squared_distance(face, place.bary, it->bary));
    if (d < best.distance) {
      best.to = StepBack::To::source;
      best.distance = d;
      best.face = place.face;
      best.start = place.bary;
      best.bary = it->bary;
      best.source = it->source;
    }
  }
  for (std::uint32_t c = 0; c < 3; ++c) {
    const double d = field_.distance[face.vertex[c]];
    if (d == kUnreached) continue;
    const double along = d + std::sqrt(squared_distance(face, place.bary, weights_at_corner(c)));
    if (along < best.distance) best = to_vertex(face, place.face, c, place.bary, along);
    const double d_next = field_.distance[face.vertex[next_corner(c)]];
    if (d_next == kUnreached || place.bary[previous_corner(c)] == 0) continue;
    const UnfoldedApex apex = apex_at(face, c, place.bary);
    const Arrival arrival = over_base(face.vertex[c], face.vertex[next_corner(c)], apex);
    if (arrival.distance < best.distance) {
      best = over_side(face, place.face, c, place.bary, arrival);
    }
  }
  return best;
}

StepBack PointArrivals::by_parents(std::uint32_t vertex) const {
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

StepBack PointArrivals::to_end_of_side(std::uint32_t f, std::uint32_t c,
                                       const std::array<double, 3>& start) const {
  const FaceRecord& face = adjacency_.face(f);
  const auto by = [&](std::uint32_t corner) {
    return field_.distance[face.vertex[corner]] +
           std::sqrt(squared_distance(face, start, weights_at_corner(corner)));
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
  return step;  // an isolated vertex that is its own source
}

double PointArrivals::distance_at(const SurfacePoint& point) const {
  if (point.at_vertex()) return field_.distance[point.vertex];
  double least = kUnreached;
  for (const SurfacePoint& place : in_all_faces(adjacency_, point)) {
    least = std::min(least, through_face(place).distance);
  }
  return least;
}

}  // namespace geodesic
