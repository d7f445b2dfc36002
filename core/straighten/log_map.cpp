#include "core/straighten/log_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "core/straighten/directions_at.h"

namespace geodesic {
namespace {

// The first segment of a path that has a length, or the number of its points.
std::size_t first_segment(const Path& path) {
  std::size_t i = 0;
  while (i + 1 < path.points.size() && path.points[i].position == path.points[i + 1].position) ++i;
  return i + 1 < path.points.size() ? i : path.points.size();
}

// Whether it is what straightest_geodesic finds.
bool is_straight(const Adjacency& adjacency, const Path& path) {
  for (std::size_t i = 1; i + 1 < path.points.size(); ++i) {
    const SurfacePoint& point = path.points[i].point;
    if (point.at_vertex()) return false;
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge side = halfedge(point.face, c);
      if (point.bary[previous_corner(c)] == 0 && adjacency.ring(adjacency.ring(side)) != side) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

Vec2 LogMap::coordinates(const Entry& entry, double x_axis) const {
  constexpr double kFullTurn = 2 * std::numbers::pi;
  constexpr double kHardlyAny = 1e-9;  // of faces that are lines
  const bool fills_a_turn = (all_round && total_angle > kHardlyAny) || total_angle > kFullTurn;
  const double angle = (fills_a_turn ? kFullTurn / total_angle : 1) * (entry.angle - x_axis);
  return {entry.distance * std::cos(angle), entry.distance * std::sin(angle)};
}

Result<LogMap> log_map(const Adjacency& adjacency, const Field& field, const SurfacePoint& from,
                       double radius, const Cancel& cancel) {
  const auto directions = DirectionsAt::of(adjacency, from, cancel);
  if (!directions) return fail(directions.error());
  LogMap map;
  map.total_angle = directions->total();
  map.all_round = directions->all_round();
  // A path takes as long as a thousand steps elsewhere, and asks by itself where it is long.
  Poll poll(cancel, 4);
  const std::uint32_t vertex_count = adjacency.mesh().vertex_count();
  std::uint64_t count = 0;
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (field.distance[v] <= radius && field.distance[v] != kUnreached) ++count;
  }
  if (!poll.may_take(count * sizeof(LogMap::Entry))) return fail_stopped(poll);
  map.entries.reserve(count);
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (!(field.distance[v] <= radius) || field.distance[v] == kUnreached) continue;
    if (poll.cancelled(map.entries.size(), count)) return fail_stopped(poll);
    const auto path =
        path_through(adjacency, field, point_at_vertex(adjacency, v), PathWork::refined, cancel);
    if (!path) return fail(path.error());
    if (!*path) continue;
    const std::size_t first = first_segment(**path);
    const auto& points = (*path)->points;
    if (first == points.size()) {
      map.entries.push_back({v, 0, 0, true});
      continue;
    }
    const Vec3 direction = points[first + 1].position - points[first].position;
    // Past edges without a length, a way may set out in a face that is not at the point.
    const auto angle = directions->angle_of(points[first].point.face, direction);
    map.entries.push_back({v, (*path)->length, angle.value_or(0),
                           angle.has_value() && is_straight(adjacency, **path)});
  }
  return map;
}

}  // namespace geodesic
