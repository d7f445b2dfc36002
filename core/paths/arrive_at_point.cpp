#include "core/paths/arrive_at_point.h"

#include <algorithm>
#include <cmath>

#include "core/base/tolerances.h"
#include "core/field/edge_points.h"
#include "core/field/line_waves.h"
#include "core/field/way_through_windows.h"
#include "core/paths/step_in_face.h"
#include "core/surface/line_gaps.h"
#include "core/wavefront/fast_marching.h"
#include "core/wavefront/novotni.h"
#include "core/wavefront/virtual_source.h"

namespace geodesic {
namespace {

// Whether corner c is the end of its side with the smaller vertex number.
bool is_low_end(const FaceRecord& face, std::uint32_t c) {
  return face.vertex[c] < face.vertex[next_corner(c)];
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

// Where a crossing of the side that starts at corner c is an end of it, for distances that
// are floats.
double rounded_at_end(const FaceRecord& face, std::uint32_t c, const Arrival& arrival) {
  if (std::min(arrival.crossing, 1 - arrival.crossing) > tolerance::kMostAtEnd)
    return tolerance::kAtEnd;
  const double rounding = tolerance::kSinglePrecisionCrossing * arrival.distance /
                          std::sqrt(std::max(face.length2(c), 0.0));
  return std::min(tolerance::kMostAtEnd, std::max(tolerance::kAtEnd, rounding));
}

}  // namespace

PointArrivals::PointArrivals(const Adjacency& adjacency, const Field& field, Poll* poll)
    : adjacency_(adjacency), field_(field), poll_(poll != nullptr ? poll : &never_stopped_) {
  if (field.kept_windows) window_paths_.emplace(adjacency, field, *poll_);
  // Vertices that lines have made sources of are corners with a distance.
  const std::size_t count = field.lines ? field.lines->given() : field.sources.size();
  for (std::uint32_t s = 0; s < count; ++s) {
    for (const SurfacePoint& place : all_faces_at(field.sources[s].point)) {
      if (stopped()) return;
      source_places_.push_back({place.face, s, place.bary});
    }
  }
  std::stable_sort(source_places_.begin(), source_places_.end(),
                   [](const SourcePlace& a, const SourcePlace& b) { return a.face < b.face; });
}

std::vector<SurfacePoint> PointArrivals::all_faces_at(const SurfacePoint& point) const {
  if (field_.method != Method::back_traced || field_.windows)
    return in_all_faces(adjacency_, point);
  return in_all_faces_at(adjacency_, point, *poll_);
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

std::span<const PointArrivals::SourcePlace> PointArrivals::sources_in(std::uint32_t face) const {
  const auto first =
      std::lower_bound(source_places_.begin(), source_places_.end(), face,
                       [](const SourcePlace& source, std::uint32_t f) { return source.face < f; });
  const auto last =
      std::upper_bound(first, source_places_.end(), face,
                       [](std::uint32_t f, const SourcePlace& source) { return f < source.face; });
  return {first, last};
}

StepBack PointArrivals::from_sources_in_face(const SurfacePoint& place) const {
  StepBack best;
  const std::span<const SourcePlace> sources = sources_in(place.face);
  if (sources.empty()) return best;
  const Sides2 side2 = sides_of(adjacency_, place.face);
  for (const SourcePlace& source : sources) {
    const double d = field_.sources[source.source].offset +
                     straight_distance(adjacency_, place.face, side2, place.bary, source.bary);
    if (d < best.distance) {
      best.to = StepBack::To::source;
      best.distance = d;
      best.face = place.face;
      best.start = place.bary;
      best.bary = source.bary;
      best.source = source.source;
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
  // Tells the caller, who asks after each face, of lists of any length.
  std::size_t windows = 0;
  for (std::uint32_t c = 0; c < 3; ++c) {
    windows += field_.windows->into(halfedge(place.face, c)).size();
  }
  (void)poll_->cancelled_after(windows / kWindowsAStep);
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

// Sources have waves of their own here, and those of a side's two ends may be of two others: the
// one beyond the side may be nearer than both, by any factor.
StepBack PointArrivals::from_sources_beyond(const SurfacePoint& place, std::uint32_t c,
                                            const UnfoldedApex& apex) const {
  const FaceRecord& face = adjacency_.face(place.face);
  const Halfedge side = halfedge(place.face, c);
  const double base2 = face.length2(c);
  StepBack best;
  for (Halfedge h = adjacency_.ring(side); h != side && !stopped(); h = adjacency_.ring(h)) {
    const bool is_turned = adjacency_.tail(h) != face.vertex[c];
    const Sides2 side2 = sides_of(adjacency_, face_of(h));
    for (const SourcePlace& source : sources_in(face_of(h))) {
      if (stopped()) return {};
      const UnfoldedApex from =
          apex_at(adjacency_.face(face_of(h)), side2, corner_of(h), source.bary);
      // Straight across the side, with the face beyond it laid into the plane of this one. As in
      // virtual_source.h, coordinates are times the side's length.
      const double along = is_turned ? from.from_q : from.from_p;
      const double across = from.height + apex.height;
      const double crossing = (along * apex.height + apex.from_p * from.height) / (across * base2);
      if (!(crossing >= 0 && crossing <= 1)) continue;
      const double run = apex.from_p - along;
      const double d =
          field_.sources[source.source].offset + std::sqrt((run * run + across * across) / base2);
      if (d < best.distance)
        best = over_side(face, place.face, c, place.bary, {d, Fig4::a, crossing});
    }
  }
  return best;
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
    if (traits.has_wave_for_each_source && field_.sources.size() > 1) {
      const StepBack beyond = from_sources_beyond(place, c, apex);
      if (beyond.distance < best.distance) best = beyond;
    }
    const Arrival arrival = over_base(face.vertex[c], face.vertex[next_corner(c)], apex);
    if (!(arrival.distance < best.distance)) continue;
    const double at_end =
        field_.distance.are_floats() ? rounded_at_end(face, c, arrival) : tolerance::kAtEnd;
    const StepBack step = over_side(face, place.face, c, place.bary, arrival, at_end);
    if (step.to != StepBack::To::vertex || field_.distance[step.vertex] < limit) best = step;
  }
  return best;
}

std::optional<double> PointArrivals::by_kept_windows(const SurfacePoint& point) const {
  return window_paths_ ? window_paths_->distance_at(point) : std::nullopt;
}

double PointArrivals::distance_at(const SurfacePoint& point) const {
  if (point.at_vertex()) return field_.distance[point.vertex];
  if (const auto told = by_kept_windows(point)) return *told;
  double least = kUnreached;
  for (const SurfacePoint& place : all_faces_at(point)) {
    if (stopped()) return kUnreached;
    const StepBack step = field_.windows ? through_windows(place) : through_face(place);
    least = std::min(least, step.distance);
  }
  return least;
}

}  // namespace geodesic
