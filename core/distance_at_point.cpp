#include "core/distance_at_point.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/refine_path.h"
#include "core/trace_path.h"

namespace geodesic {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// A path's length, and what rounding may have taken off it: of a sum of n segments n epsilon;
// of each end of a segment some epsilon of its coordinates.
double not_below_length(const Path& path) {
  constexpr double kOfPosition = 12 * kEpsilon;
  double farthest_out = 0;
  for (const PathPoint& point : path.points) {
    const Vec3 p = point.position;
    farthest_out = std::max({farthest_out, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  const auto count = static_cast<double>(path.points.size());
  return path.length * (1 + (count + 4) * kEpsilon) + count * kOfPosition * farthest_out;
}

// The length of the shortest way to the point that is known.
Result<double> length_of_way(const Adjacency& adjacency, const Field& field,
                             const SurfacePoint& point, const Cancel& cancel) {
  Poll poll(cancel);
  double least = kUnreached;
  for (const SurfacePoint& place : in_all_faces(adjacency, point)) {
    if (poll.cancelled()) return fail_stopped(poll);
    for (std::uint32_t c = 0; c < 3; ++c) {
      const double d = field.distance[adjacency.face(place.face).vertex[c]];
      least = std::min(least, d + distance_to_corner(adjacency.mesh(), place, c));
    }
  }
  least *= 1 + 4 * kEpsilon;
  const auto traced = trace_path(adjacency, field, point, cancel);
  if (!traced) return fail(traced.error());
  if (!*traced) return least;
  const auto path = refine_path(adjacency, field, point, **traced, cancel);
  if (!path) return fail(path.error());
  return std::min(least, field.sources[path->source].offset + not_below_length(*path));
}

}  // namespace

Result<double> distance_at_point(const Adjacency& adjacency, const Field& field,
                                 const PointArrivals& arrivals, const SurfacePoint& point,
                                 const Cancel& cancel) {
  const bool is_told = field.bound == Bound::none || point.at_vertex() || field.windows;
  if (is_told) return arrivals.distance_at(point);
  return length_of_way(adjacency, field, point, cancel);
}

}  // namespace geodesic
