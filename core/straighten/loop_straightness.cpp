#include "core/straighten/loop_straightness.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "core/base/vec3.h"
#include "core/straighten/path_chain.h"
#include "core/straighten/vertex_fan.h"

namespace geodesic {
namespace {

using std::numbers::pi;

double angle_in_space(Vec3 a, Vec3 b) { return std::atan2(norm(cross(a, b)), dot(a, b)); }

// In radians, by how much the directions from a point may be off: coordinates are rounded, and the
// shorter of its segments says how much that turns it.
double rounding_at(Vec3 before, Vec3 at, Vec3 after) {
  constexpr double kRoundings = 16 * std::numeric_limits<double>::epsilon();
  const double arm = std::min(distance(at, before), distance(at, after));
  const double size = std::max(std::abs(at.x), std::max(std::abs(at.y), std::abs(at.z)));
  return arm > 0 ? kRoundings * (1 + size / arm) : pi;
}

}  // namespace

double turn_inside(const Adjacency& adjacency, const PathPoint& before, const PathPoint& at,
                   const PathPoint& after) {
  const Vec3 back = before.position - at.position;
  const Vec3 on = after.position - at.position;
  if (!(norm(back) > 0 && norm(on) > 0)) return 0;
  double turn = pi - angle_in_space(back, on);  // in one face
  const Halfedge under = edge_under(at.point);
  if (under != kNone && before.point.face != at.point.face) {
    const auto positions = adjacency.mesh().positions();
    const Vec3 edge = positions[adjacency.head(under)] - positions[adjacency.tail(under)];
    turn = std::abs(pi - angle_in_space(edge, back) - angle_in_space(edge, on));
  }
  return std::max(0.0, turn - rounding_at(before.position, at.position, after.position));
}

Result<LoopStraightness> straightness_of_loop(const Adjacency& adjacency, const Path& loop,
                                              const Cancel& cancel) {
  Poll poll(cancel);
  LoopStraightness worst;
  const auto& points = loop.points;
  if (points.size() < 3) return worst;
  const std::size_t count = points.size() - 1;
  for (std::size_t i = 0; i < count; ++i) {
    if (poll.cancelled()) return fail_stopped(poll);
    if (points[i].point.at_vertex()) continue;
    const double turn =
        turn_inside(adjacency, points[i == 0 ? count - 1 : i - 1], points[i], points[i + 1]);
    worst.turn = std::max(worst.turn, turn);
    worst.lack = std::max(worst.lack, turn);
  }
  const auto chain = read_chain(adjacency, loop, poll);
  if (poll.stopped()) return fail_stopped(poll);
  if (!chain) {
    worst.is_known = false;
    return worst;
  }
  FanSearch fans(adjacency, poll);
  const std::size_t segments = chain->segments.size();
  // By the places of the path vertices among the points.
  std::size_t place = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    if (poll.cancelled()) return fail_stopped(poll);
    const SurfacePoint& vertex = chain->path_vertices[i].place;
    if (vertex.at_vertex()) {
      while (place < count && points[place].point.vertex != vertex.vertex) ++place;
      const DirectionAtVertex& arrives = chain->segments[i == 0 ? segments - 1 : i - 1].arrives;
      const DirectionAtVertex& leaves = chain->segments[i].leaves;
      // It begins at a vertex and ends at a point beside it that is at the same place.
      if (arrives.face == kNone || leaves.face == kNone) {
        worst.is_known = false;
        ++place;
        continue;
      }
      const std::size_t last = place == 0 ? count - 1 : place - 1;
      const auto fan =
          fans.least(vertex.vertex, arrives, leaves, std::numeric_limits<double>::infinity());
      // Of the fan that the path leaves by: at a pinched vertex there are others.
      const auto total = closed_fan_angle(
          adjacency, halfedge(leaves.face, corner_at(adjacency, leaves.face, vertex.vertex)), poll);
      if (poll.stopped()) return fail_stopped(poll);
      if (fan && place < count) {
        const double rounding =
            rounding_at(points[last].position, points[place].position, points[place + 1].position);
        const double straight = total ? std::min(pi, *total / 2) : pi;
        worst.turn = std::max(worst.turn, straight - fan->angle - rounding);
        worst.lack = std::max(worst.lack, pi - fan->angle - rounding);
      }
      ++place;
    }
  }
  return worst;
}

}  // namespace geodesic
