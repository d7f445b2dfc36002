#include "core/solve/ways_to_sources.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/paths/edge_path.h"
#include "core/straighten/shorten_path.h"

namespace geodesic {
namespace {

constexpr std::size_t kMostSourcesAsked = 8;

// Whether a vertex of the source's own face is nearer to another source: then the points about
// may be its own, and no vertex say so.
bool is_hidden(const Adjacency& adjacency, const Field& field, std::uint32_t s) {
  const SurfacePoint& place = field.sources[s].point;
  if (place.at_vertex()) return false;
  const auto& corners = adjacency.face(place.face).vertex;
  return std::any_of(corners.begin(), corners.end(),
                     [&](std::uint32_t v) { return field.nearest_source[v] != s; });
}

// Whether the corners of the point's face are nearest to several sources. Then what is nearest to
// yet another one may reach between two of them.
bool is_between_cells(const Adjacency& adjacency, const Field& field, const SurfacePoint& point) {
  const auto& corners = adjacency.face(point.face).vertex;
  const std::uint32_t first = field.nearest_source[corners[0]];
  return field.nearest_source[corners[1]] != first || field.nearest_source[corners[2]] != first;
}

}  // namespace

double not_below_length(const Path& path) {
  // From a point to itself nothing is rounded.
  const SurfacePoint& from = path.points.front().point;
  const SurfacePoint& to = path.points.back().point;
  if (path.length == 0 && from.face == to.face && from.bary == to.bary) return 0;
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  constexpr double kOfPosition = 12 * kEpsilon;
  double farthest_out = 0;
  for (const PathPoint& point : path.points) {
    const Vec3 p = point.position;
    farthest_out = std::max({farthest_out, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  const auto count = static_cast<double>(path.points.size());
  return path.length * (1 + (count + 4) * kEpsilon) + count * kOfPosition * farthest_out;
}

double straight_from(const Adjacency& adjacency, const Field& field, std::uint32_t s,
                     const SurfacePoint& point) {
  const Mesh& mesh = adjacency.mesh();
  const Source& source = field.sources[s];
  return source.offset + distance(position_of(mesh, source.point), position_of(mesh, point));
}

bool may_be_of_another(const Adjacency& adjacency, const Field& field, const SurfacePoint& point,
                       double told, Poll& poll) {
  if (field.nearest_source.empty() || field.sources.size() < 3) return false;
  if (!is_between_cells(adjacency, field, point)) return false;
  const auto& corners = adjacency.face(point.face).vertex;
  for (std::uint32_t s = 0; s < field.sources.size() && !poll.cancelled(); ++s) {
    const bool is_known = std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
      return field.nearest_source[v] == s;
    });
    if (!is_known && straight_from(adjacency, field, s, point) < told) return true;
  }
  return false;
}

Result<double> WaysToSources::below(double least, std::uint32_t asked) {
  Poll poll(cancel_);
  std::vector<std::uint32_t> others;
  const auto& corners = adjacency_.face(point_.face).vertex;
  others.reserve(corners.size() + kMostSourcesAsked);
  for (const std::uint32_t v : corners) others.push_back(field_.nearest_source[v]);
  const bool is_between = is_between_cells(adjacency_, field_, point_);
  std::vector<std::pair<double, std::uint32_t>> about;
  for (std::uint32_t s = 0; s < field_.sources.size(); ++s) {
    if (poll.cancelled()) return fail_stopped(poll);
    const double straight = straight_from(adjacency_, field_, s, point_);
    if (!(straight < least) || !(is_between || is_hidden(adjacency_, field_, s))) continue;
    about.emplace_back(straight, s);
    std::push_heap(about.begin(), about.end());
    if (about.size() <= kMostSourcesAsked) continue;
    std::pop_heap(about.begin(), about.end());
    about.pop_back();
  }
  for (const auto& [straight, s] : about) others.push_back(s);
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  for (const std::uint32_t s : others) {
    if (s == kNone || s == asked || !is_near(s, least)) continue;
    auto length = from(s);
    if (!length) return length;
    least = std::min(least, *length);
  }
  return least;
}

Result<double> WaysToSources::from(std::uint32_t s) {
  const Source& source = field_.sources[s];
  const auto along_edges = edge_path(adjacency_, source.point, point_, scratch_, cancel_);
  if (!along_edges) return fail(along_edges.error());
  if (!*along_edges) return kUnreached;
  const auto path = shorten_path(adjacency_, **along_edges, cancel_);
  if (!path) return fail(path.error());
  return source.offset + not_below_length(*path);
}

}  // namespace geodesic
