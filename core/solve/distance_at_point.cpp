#include "core/solve/distance_at_point.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/paths/edge_path.h"
#include "core/paths/trace_path.h"
#include "core/straighten/refine_path.h"
#include "core/straighten/shorten_path.h"
#include "core/wavefront/wavefront.h"

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

// Whether a vertex of the source's own face is nearer to another source: then the points about
// may be its own, and no vertex say so.
bool is_hidden(const Adjacency& adjacency, const Field& field, std::uint32_t s) {
  const SurfacePoint& place = field.sources[s].point;
  if (place.at_vertex()) return false;
  const auto& corners = adjacency.face(place.face).vertex;
  return std::any_of(corners.begin(), corners.end(),
                     [&](std::uint32_t v) { return field.nearest_source[v] != s; });
}

// Where several sources meet, the distances of a face's corners do not lead to the nearest one of
// a point between them. Ways to the sources themselves do: to those of the corners, and to those
// that no vertex leads to. Each from the shortest along edges, so few are asked.
class WaysToOtherSources {
 public:
  WaysToOtherSources(const Adjacency& adjacency, const Field& field, const SurfacePoint& point,
                     const Cancel& cancel)
      : adjacency_(adjacency), field_(field), point_(point), cancel_(cancel) {}

  // The shortest that is below `least`, or that; without the source that has been asked.
  Result<double> below(double least, std::uint32_t asked) {
    Poll poll(cancel_);
    std::vector<std::uint32_t> others;
    const auto& corners = adjacency_.face(point_.face).vertex;
    for (const std::uint32_t v : corners) others.push_back(field_.nearest_source[v]);
    for (std::uint32_t s = 0; s < field_.sources.size() && others.size() < kMostAsked; ++s) {
      if (poll.cancelled()) return fail_stopped(poll);
      if (is_near(s, least) && is_hidden(adjacency_, field_, s)) others.push_back(s);
    }
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    for (const std::uint32_t s : others) {
      if (s == kNone || s == asked || !is_near(s, least)) continue;
      const auto length = from(s);
      if (!length) return length;
      least = std::min(least, *length);
    }
    return least;
  }

 private:
  static constexpr std::size_t kMostAsked = 8;

  [[nodiscard]] bool is_near(std::uint32_t s, double least) const {
    const Mesh& mesh = adjacency_.mesh();
    const Source& source = field_.sources[s];
    return source.offset + distance(position_of(mesh, source.point), position_of(mesh, point_)) <
           least;
  }

  Result<double> from(std::uint32_t s) {
    const Source& source = field_.sources[s];
    const auto along_edges = edge_path(adjacency_, source.point, point_, scratch_, cancel_);
    if (!along_edges) return fail(along_edges.error());
    if (!*along_edges) return kUnreached;
    const auto path = shorten_path(adjacency_, **along_edges, cancel_);
    if (!path) return fail(path.error());
    return source.offset + not_below_length(*path);
  }

  const Adjacency& adjacency_;
  const Field& field_;
  const SurfacePoint& point_;
  const Cancel& cancel_;
  WavefrontScratch scratch_;
};

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
  least = std::min(least, field.sources[path->source].offset + not_below_length(*path));
  if (field.nearest_source.empty()) return least;
  return WaysToOtherSources(adjacency, field, point, cancel).below(least, path->source);
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
