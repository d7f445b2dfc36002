#include "core/paths/arrive_at_point.h"

#include <algorithm>
#include <cmath>

#include "core/base/tolerances.h"
#include "core/field/edge_points.h"
#include "core/field/way_through_windows.h"
#include "core/surface/side_length.h"
#include "core/wavefront/fast_marching.h"
#include "core/wavefront/novotni.h"
#include "core/wavefront/virtual_source.h"

namespace geodesic {
namespace {

// So many are a step to the poll.
constexpr std::size_t kWindowsAStep = 16;

using Weights = std::array<double, 3>;

Weights weights_at_corner(std::uint32_t corner) {
  Weights bary{0, 0, 0};
  bary[corner] = 1;
  return bary;
}

// Whether corner c is the end of its side with the smaller vertex number.
bool is_low_end(const FaceRecord& face, std::uint32_t c) {
  return face.vertex[c] < face.vertex[next_corner(c)];
}

// The squared lengths of a face's sides, from the one that starts at corner 0.
using Sides2 = std::array<double, 3>;

Sides2 sides_of(const Adjacency& adjacency, std::uint32_t f) {
  const FaceRecord& face = adjacency.face(f);
  Sides2 side2{face.length2(0), face.length2(1), face.length2(2)};
  const double least = std::min(std::min(side2[0], side2[1]), side2[2]);
  if (!(least > tolerance::kHalfOfDigits * (side2[0] + side2[1] + side2[2]))) [[unlikely]] {
    for (std::uint32_t c = 0; c < 3; ++c) side2[c] = side_length2(adjacency, f, c);
  }
  return side2;
}

// Squared distance between two points of a face; differences of weights add up to
// zero, so |sum u_i x_i|^2 = -sum over sides u_i u_j |x_i - x_j|^2.
double squared_distance(const Sides2& side2, const Weights& a, const Weights& b) {
  double sum = 0;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const std::uint32_t n = next_corner(c);
    sum -= (a[c] - b[c]) * (a[n] - b[n]) * side2[c];
  }
  return std::max(sum, 0.0);
}

// The straight line in space between two points of a face. Where they are so near to each other
// that the sides' squares have lost it, by their positions.
double straight_distance(const Adjacency& adjacency, std::uint32_t f, const Sides2& side2,
                         const Weights& a, const Weights& b) {
  const double square = squared_distance(side2, a, b);
  const double longest2 = std::max(std::max(side2[0], side2[1]), side2[2]);
  if (square > tolerance::kNearInFace2 * longest2) [[likely]]
    return std::sqrt(square);
  const auto positions = adjacency.mesh().positions();
  const FaceRecord& face = adjacency.face(f);
  const Vec3 corner = positions[face.vertex[0]];
  return norm((a[1] - b[1]) * (positions[face.vertex[1]] - corner) +
              (a[2] - b[2]) * (positions[face.vertex[2]] - corner));
}

// The point as an apex over the side that starts at corner c.
UnfoldedApex apex_at(const FaceRecord& face, const Sides2& side2, std::uint32_t c,
                     const Weights& bary) {
  const std::uint32_t n = next_corner(c);
  const double above = bary[previous_corner(c)];
  const double base2 = face.length2(c);
  return {bary[n] * base2 + above * face.dot[c], bary[c] * base2 + above * face.dot[n],
          above * face.area2, squared_distance(side2, bary, weights_at_corner(c)),
          squared_distance(side2, bary, weights_at_corner(n))};
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

// Where a crossing of the side that starts at corner c is an end of it, for distances that
// are floats.
double rounded_at_end(const FaceRecord& face, std::uint32_t c, const Arrival& arrival) {
  if (std::min(arrival.crossing, 1 - arrival.crossing) > tolerance::kMostAtEnd)
    return tolerance::kAtEnd;
  const double rounding = tolerance::kSinglePrecisionCrossing * arrival.distance /
                          std::sqrt(std::max(face.length2(c), 0.0));
  return std::min(tolerance::kMostAtEnd, std::max(tolerance::kAtEnd, rounding));
}

// The step that case (a), (b) or (c) of the paper's Fig. 4 asks for.
StepBack over_side(const FaceRecord& face, std::uint32_t f, std::uint32_t c, const Weights& start,
                   const Arrival& arrival, double at_end = tolerance::kAtEnd) {
  const std::uint32_t n = next_corner(c);
  if (arrival.which == Fig4::b || arrival.crossing < at_end) {
    return to_vertex(face, f, c, start, arrival.distance);
  }
  if (arrival.which == Fig4::c || arrival.crossing > 1 - at_end) {
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

PointArrivals::PointArrivals(const Adjacency& adjacency, const Field& field, Poll* poll)
    : adjacency_(adjacency), field_(field), poll_(poll) {
  for (std::uint32_t s = 0; s < field.sources.size(); ++s) {
    for (const SurfacePoint& place : in_all_faces(adjacency, field.sources[s].point)) {
      if (stopped()) return;
      source_places_.push_back({place.face, s, place.bary});
    }
  }
  std::stable_sort(source_places_.begin(), source_places_.end(),
                   [](const SourcePlace& a, const SourcePlace& b) { return a.face < b.face; });
}

// In the order that steps of the same length are taken in.
int PointArrivals::steps_to_go(const StepBack& step) const {
  if (step.to == StepBack::To::source) return 0;
  const FaceRecord& face = adjacency_.face(step.face);
  if (!(squared_distance(sides_of(adjacency_, step.face), step.start, step.bary) >
        tolerance::kStays2 * face.longest2()))
    return 3;
  return step.to == StepBack::To::vertex ? 1 : 2;
}

bool PointArrivals::is_better(const StepBack& step, const StepBack& than) const {
  if (step.distance < than.distance * (1 - tolerance::kSameWay)) return true;
  if (!(step.distance <= than.distance * (1 + tolerance::kSameWay)) ||
      step.to == StepBack::To::nowhere) {
    return false;
  }
  const int more = steps_to_go(step) - steps_to_go(than);
  return more != 0 ? more < 0 : step.distance < than.distance;
}

// The method's own rule for a third vertex.
Arrival PointArrivals::over_base(std::uint32_t p, std::uint32_t q, const UnfoldedApex& apex) const {
  const double dp = field_.distance[p];
  const double dq = field_.distance[q];
  // One front of all sources, straight whichever they are.
  if (field_.method == Method::fast_marching) return arrive_plane_wave(dp, dq, apex);
  if (!field_.same_source(p, q) || field_.method == Method::dijkstra) {
    return arrive_along_sides(dp, dq, apex);
  }
  // Circles around the virtual source have no offset in them.
  const double offset =
      field_.sources[field_.nearest_source.empty() ? 0 : field_.nearest_source[p]].offset;
  const auto rule = field_.method == Method::novotni ? arrive_without_cases : arrive;
  Arrival arrival = rule(dp - offset, dq - offset, apex);
  arrival.distance += offset;
  return arrival;
}

StepBack PointArrivals::from_sources_in_face(const SurfacePoint& place) const {
  StepBack best;
  const auto first =
      std::lower_bound(source_places_.begin(), source_places_.end(), place.face,
                       [](const SourcePlace& source, std::uint32_t f) { return source.face < f; });
  if (first == source_places_.end() || first->face != place.face) return best;
  const Sides2 side2 = sides_of(adjacency_, place.face);
  for (auto it = first; it != source_places_.end() && it->face == place.face; ++it) {
    const double d = field_.sources[it->source].offset +
                     straight_distance(adjacency_, place.face, side2, place.bary, it->bary);
    if (d < best.distance) {
      best.to = StepBack::To::source;
      best.distance = d;
      best.face = place.face;
      best.start = place.bary;
      best.bary = it->bary;
      best.source = it->source;
    }
  }
  return best;
}

double PointArrivals::below(const SurfacePoint& place) const {
  if (traits_of(field_.method).has_parents) return kUnreached;
  if (place.at_vertex()) return field_.distance[place.vertex];
  if (!field_.edge_points) return kUnreached;
  const EdgePoints& points = *field_.edge_points;
  for (std::uint32_t c = 0; c < 3; ++c) {
    if (place.bary[previous_corner(c)] != 0) continue;
    // Where it lies among the edge's points, in units of their spacing.
    const double from_low =
        place.bary[is_low_end(adjacency_.face(place.face), c) ? next_corner(c) : c];
    const double at = from_low * (double(points.per_edge) + 1);
    const double nearest = std::round(at);
    if (std::abs(at - nearest) > tolerance::kAtSteinerPoint || nearest < 1 ||
        nearest > points.per_edge)
      break;
    return points.distance[std::size_t{points.edge_of[halfedge(place.face, c)]} * points.per_edge +
                           static_cast<std::size_t>(nearest) - 1];
  }
  return kUnreached;
}

StepBack PointArrivals::straight_in_face(const SurfacePoint& place, double limit) const {
  const Sides2 side2 = sides_of(adjacency_, place.face);
  const FaceRecord& face = adjacency_.face(place.face);
  StepBack best = from_sources_in_face(place);
  for (std::uint32_t c = 0; c < 3; ++c) {
    const double d = field_.distance[face.vertex[c]];
    if (!(d < limit)) continue;
    const double along =
        d + straight_distance(adjacency_, place.face, side2, place.bary, weights_at_corner(c));
    if (along < best.distance) best = to_vertex(face, place.face, c, place.bary, along);
  }
  return best;
}

StepBack PointArrivals::through_graph(const SurfacePoint& place) const {
  const Sides2 side2 = sides_of(adjacency_, place.face);
  const FaceRecord& face = adjacency_.face(place.face);
  const double limit = below(place);
  StepBack best = straight_in_face(place, limit);
  if (!field_.edge_points) return best;
  const EdgePoints& points = *field_.edge_points;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const std::uint32_t low = is_low_end(face, c) ? c : next_corner(c);
    const std::uint32_t high = low == c ? next_corner(c) : c;
    const std::size_t first =
        std::size_t{points.edge_of[halfedge(place.face, c)]} * points.per_edge;
    for (std::uint32_t i = 0; i < points.per_edge; ++i) {
      const double d = points.distance[first + i];
      if (!(d < limit) || !(d < best.distance)) continue;
      Weights bary{0, 0, 0};
      bary[high] = (double(i) + 1) / (double(points.per_edge) + 1);
      bary[low] = 1 - bary[high];
      const double through = d + std::sqrt(squared_distance(side2, place.bary, bary));
      if (!(through < best.distance)) continue;
      best.to = StepBack::To::edge;
      best.distance = through;
      best.face = place.face;
      best.start = place.bary;
      best.bary = bary;
      best.base = halfedge(place.face, c);
    }
  }
  return best;
}

StepBack PointArrivals::through_windows(const SurfacePoint& place) const {
  const StepBack best = straight_in_face(place, below(place));
  if (!field_.windows) return best;
  const WayThroughWindow way = shortest_way_through_windows(adjacency_, *field_.windows, place);
  if (poll_ != nullptr) {
    // Tells the caller, who asks after each face, of lists of any length.
    std::size_t windows = 0;
    for (std::uint32_t c = 0; c < 3; ++c)
      windows += field_.windows->into(halfedge(place.face, c)).size();
    (void)poll_->cancelled_after(windows / kWindowsAStep);
  }
  // Straight there, if that is as near: a way over a line may be as near through anything.
  if (!(way.distance < best.distance * (1 - tolerance::kSameWay))) return best;
  const FaceRecord& face = adjacency_.face(place.face);
  // By a vertex at the end of the side if that costs nothing. It does where the way leads round
  // something narrower than tolerance::kAtEnd, such as the ring at a pole.
  const std::uint32_t end = way.crossing < 0.5 ? way.corner : next_corner(way.corner);
  double at_end = tolerance::kAtEndSurely;
  if (std::min(way.crossing, 1 - way.crossing) < tolerance::kAtEnd) {
    const double by_end = field_.distance[face.vertex[end]] +
                          std::sqrt(squared_distance(sides_of(adjacency_, place.face), place.bary,
                                                     weights_at_corner(end)));
    if (by_end <= way.distance * (1 + tolerance::kSameWay)) at_end = tolerance::kAtEnd;
  }
  return over_side(face, place.face, way.corner, place.bary, {way.distance, Fig4::a, way.crossing},
                   at_end);
}

StepBack PointArrivals::through_face(const SurfacePoint& place) const {
  const MethodTraits traits = traits_of(field_.method);
  if (traits.has_edge_points) return through_graph(place);
  if (traits.has_windows) return through_windows(place);
  const Sides2 side2 = sides_of(adjacency_, place.face);
  const FaceRecord& face = adjacency_.face(place.face);
  StepBack best = from_sources_in_face(place);
  const double limit = below(place);
  for (std::uint32_t c = 0; c < 3; ++c) {
    const double d = field_.distance[face.vertex[c]];
    if (d == kUnreached) continue;
    const double along =
        d + straight_distance(adjacency_, place.face, side2, place.bary, weights_at_corner(c));
    if (along < best.distance && d < limit) {
      best = to_vertex(face, place.face, c, place.bary, along);
    }
    const double d_next = field_.distance[face.vertex[next_corner(c)]];
    if (d_next == kUnreached || place.bary[previous_corner(c)] == 0) continue;
    const UnfoldedApex apex = apex_at(face, side2, c, place.bary);
    const Arrival arrival = over_base(face.vertex[c], face.vertex[next_corner(c)], apex);
    if (!(arrival.distance < best.distance)) continue;
    const double at_end =
        field_.distance.are_floats() ? rounded_at_end(face, c, arrival) : tolerance::kAtEnd;
    const StepBack step = over_side(face, place.face, c, place.bary, arrival, at_end);
    if (step.to != StepBack::To::vertex || field_.distance[step.vertex] < limit) best = step;
  }
  return best;
}

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
  return step;  // an isolated vertex that is its own source
}

double PointArrivals::distance_at(const SurfacePoint& point) const {
  if (point.at_vertex()) return field_.distance[point.vertex];
  double least = kUnreached;
  for (const SurfacePoint& place : in_all_faces(adjacency_, point)) {
    if (stopped()) return kUnreached;
    const StepBack step = field_.windows ? through_windows(place) : through_face(place);
    least = std::min(least, step.distance);
  }
  return least;
}

}  // namespace geodesic
