#include "core/solve/distance_at_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/tolerances.h"
#include "core/exact/field.h"
#include "core/field/line_waves.h"
#include "core/solve/ways_to_sources.h"
#include "core/straighten/refine_path.h"
#include "core/wavefront/virtual_source.h"
#include "core/wavefront/wavefront.h"

namespace geodesic {
namespace {

// Of a face's longest side, its height. In a lower one, circles round two corners meet anywhere.
constexpr double kLow = 0.1;
// By what part of a distance the pairs of corners may differ. With more, points round holes are
// farther off; with less, many points of fine meshes ask for a path.
constexpr double kDiffers = 0.002;

// How far it is from a point where circles round two corners of a face meet, in plane coordinates
// times the length of the side between them, as in virtual_source.h: the side from p to q lies on
// the x axis, the face above it. They meet beyond the side, and mirrored on the face's own side.
struct Meeting {
  double base2;
  double x;
  double y;  // below the side if positive

  Meeting(double square, double dp, double dq)
      : base2(square),
        x(0.5 * (base2 + (dp - dq) * (dp + dq))),
        y(0.5 * std::sqrt(std::max(
                    0.0, ((dp + dq) * (dp + dq) - base2) * (base2 - (dp - dq) * (dp - dq))))) {}

  [[nodiscard]] double to(double along, double height) const {
    return std::sqrt(((along - x) * (along - x) + (height + y) * (height + y)) / base2);
  }
};

// Whether the ways to a face's corners come from different sides, as far as the distances tell.
// One source far away is where the circles round any two corners meet: the third corner is as far
// from there as its distance says, and by each pair the point is as far as by the others. `about`:
// what the nearest meeting says of the point.
bool ways_differ(const FaceRecord& face, const Field& field, const SurfacePoint& point,
                 double about) {
  // Circles have no offset in them.
  const auto offset_at = [&](std::uint32_t v) {
    const std::uint32_t source = field.nearest_source.empty() ? 0 : field.nearest_source[v];
    return source < field.sources.size() ? field.sources[source].offset : 0;  // not reached
  };
  const double offset = offset_at(face.vertex[0]);
  if (offset_at(face.vertex[1]) != offset || offset_at(face.vertex[2]) != offset) return true;
  const auto distance = [&](std::uint32_t c) { return field.distance[face.vertex[c]] - offset; };
  // Which has taken digits from the distances, too.
  const double rounding = 2 * tolerance::kSinglePrecision * offset;
  double least = about - offset;
  double most = least;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const std::uint32_t n = next_corner(c);
    const std::uint32_t third = previous_corner(c);
    const double wanted = distance(third);
    const UnfoldedApex apex = face.apex_over(c);
    Meeting meeting(apex.base2(), distance(c), distance(n));
    Meeting mirrored = meeting;
    mirrored.y = -meeting.y;
    const auto wrong = [&](const Meeting& at) {
      return std::abs(at.to(apex.from_p, apex.height) - wanted);
    };
    if (wrong(mirrored) < wrong(meeting)) meeting = mirrored;
    if (!(wrong(meeting) <= kDiffers * wanted + rounding)) return true;
    const double above = point.bary[third];
    const double said =
        meeting.to(point.bary[n] * apex.base2() + above * apex.from_p, above * apex.height);
    least = std::min(least, said);
    most = std::max(most, said);
  }
  return !(most - least <= kDiffers * least + rounding);
}

// Whether circles say little of the point.
bool is_awkward(const Adjacency& adjacency, const Field& field, const SurfacePoint& point,
                double about) {
  const FaceRecord& face = adjacency.face(point.face);
  return !(face.area2 > kLow * face.longest2()) || ways_differ(face, field, point, about);
}

// A path that is longer by this factor than the circles say has gone round the wrong side.
constexpr double kWrongSide = 1.05;

// The length of the shortest way to the point that is known: along that path, if there is one, or
// straight from a corner. `about`: what the circles say.
Result<double> length_of_way(const Adjacency& adjacency, const Field& field,
                             const SurfacePoint& point, const std::optional<Path>& path,
                             double about, const Cancel& cancel) {
  Poll poll(cancel);
  double least = kUnreached;
  for (const SurfacePoint& place : in_all_faces(adjacency, point)) {
    if (poll.cancelled()) return fail_stopped(poll);
    for (std::uint32_t c = 0; c < 3; ++c) {
      const double d = field.distance[adjacency.face(place.face).vertex[c]];
      least = std::min(least, d + distance_to_corner(adjacency.mesh(), place, c));
    }
  }
  least *= 1 + 4 * std::numeric_limits<double>::epsilon();
  if (!path) return least;
  const double offset = field.sources[path->source].offset;
  least = std::min(least, offset + not_below_length(*path));
  WaysToSources ways(adjacency, field, point, cancel);
  // Without the offset, beside which no way round would be seen; but it has taken digits from what
  // the circles say.
  const double most = offset + kWrongSide * (about - offset) + tolerance::kSinglePrecision * offset;
  if (least > most && is_awkward(adjacency, field, point, about)) {
    auto along_edges = ways.from(path->source);
    if (!along_edges) return along_edges;
    least = std::min(least, *along_edges);
  }
  // Of the sources that lines have put at vertices, the way of each is in the distances there.
  if (field.nearest_source.empty() || field.lines) return least;
  return ways.below(least, path->source);
}

// Whether the field says by itself how far the point is.
bool is_told(const Adjacency& adjacency, const Field& field, const SurfacePoint& point, double told,
             Poll& poll) {
  if (point.at_vertex() || field.windows) return true;
  if (field.bound == Bound::upper) return false;
  if (field.method != Method::back_traced) return true;
  return !is_awkward(adjacency, field, point, told) &&
         (field.lines || !may_be_of_another(adjacency, field, point, told, poll));
}

// With more sources nobody is asked for each how far it is straight.
constexpr std::size_t kFewSources = 64;

// Circles may say less than the straight line in space, by more than fields are rounded.
double not_below_straight_line(const Adjacency& adjacency, const Field& field,
                               const SurfacePoint& point, double told) {
  if (point.at_vertex() || field.method != Method::back_traced || field.windows) return told;
  if (field.sources.size() > kFewSources) return told;
  double straight = kUnreached;
  for (std::uint32_t s = 0; s < field.sources.size(); ++s) {
    straight = std::min(straight, straight_from(adjacency, field, s, point));
  }
  return told < straight * (1 - tolerance::kSinglePrecision) ? straight : told;
}

Result<double> distance_by_points(const Adjacency& adjacency, const Field& field,
                                  const PointArrivals& arrivals, const SurfacePoint& point,
                                  const std::optional<Path>* refined, const Cancel& cancel) {
  const std::optional<double> by_windows = arrivals.by_kept_windows(point);
  const bool are_the_answer = field.kept_windows && field.kept_windows->are_the_answer;
  if (are_the_answer && !by_windows && !arrivals.was_stopped()) {
    const auto over_mesh = exact_field_over_mesh(adjacency, field, point, cancel);
    if (!over_mesh) return fail(over_mesh.error());
    Poll poll(cancel);
    const double told = PointArrivals(adjacency, *over_mesh, &poll).distance_at(point);
    return poll.stopped() ? fail_stopped(poll) : Result<double>(told);
  }
  const double told = by_windows ? *by_windows : arrivals.distance_at(point);
  if (arrivals.was_stopped()) return fail_stopped(cancel);
  if (by_windows && (field.bound == Bound::none || are_the_answer)) {
    return not_below_straight_line(adjacency, field, point, told);
  }
  Poll poll(cancel);
  const bool is_enough = is_told(adjacency, field, point, told, poll);
  if (poll.stopped()) return fail_stopped(poll);
  if (is_enough) {
    return not_below_straight_line(adjacency, field, point, told);
  }
  if (refined != nullptr) return length_of_way(adjacency, field, point, *refined, told, cancel);
  const auto path = path_through(adjacency, field, point, PathWork::refined, cancel);
  if (!path) return fail(path.error());
  return length_of_way(adjacency, field, point, *path, told, cancel);
}

// From points that are sources, and straight from lines that are.
Result<double> distance_in_face(const Adjacency& adjacency, const Field& field,
                                const PointArrivals& arrivals, const SurfacePoint& point,
                                const std::optional<Path>* refined, const Cancel& cancel) {
  if (!field.lines) return distance_by_points(adjacency, field, arrivals, point, refined, cancel);
  Poll poll(cancel);
  const double straight = field.lines->arrive(adjacency, point, &poll).distance;
  if (poll.stopped()) return fail_stopped(poll);
  if (straight == 0) return straight;
  auto round = distance_by_points(adjacency, field, arrivals, point, refined, cancel);
  return round ? std::min(straight, *round) : round;
}

}  // namespace

Result<double> distance_at_point(const Adjacency& adjacency, const Field& field,
                                 const PointArrivals& arrivals, const SurfacePoint& point,
                                 const Cancel& cancel) {
  return distance_in_face(adjacency, field, arrivals, point, nullptr, cancel);
}

Result<double> distance_at_point(const Adjacency& adjacency, const Field& field,
                                 const PointArrivals& arrivals, const SurfacePoint& point,
                                 const std::optional<Path>& refined, const Cancel& cancel) {
  return distance_in_face(adjacency, field, arrivals, point, &refined, cancel);
}

}  // namespace geodesic
