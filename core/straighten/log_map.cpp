#include "core/straighten/log_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "core/straighten/directions_at.h"
#include "core/straighten/face_strip.h"
#include "core/straighten/flat_face.h"
#include "core/straighten/path_chain.h"

namespace geodesic {
namespace {

// In which direction paths set out, in the plane of their first face. Told by the end of all that
// is straight: a first segment may be as short as rounding leaves it.
class Departures {
 public:
  Departures(const Adjacency& adjacency, Poll& poll) : adjacency_(adjacency), poll_(poll) {}

  // Of no use if the poll says to stop. None of a path without a length, nor where edges without a
  // length leave none.
  std::optional<Vec3> direction_of(const Path& path) {
    strip_.first_face = path.points.front().point.face;
    strip_.portals.clear();
    std::size_t end = 1;
    for (; end + 1 < path.points.size() && !path.points[end].point.at_vertex(); ++end) {
      const SurfacePoint& point = path.points[end].point;
      const std::uint32_t before = path.points[end - 1].point.face;
      if (point.face == before) continue;
      const auto portal = portal_at(adjacency_, before, point, poll_);
      if (!portal) break;
      strip_.cross(*portal);
    }
    if (end >= path.points.size()) return std::nullopt;
    const SurfacePoint& first = path.points.front().point;
    const SurfacePoint& last = path.points[end].point;
    // Past edges without a length they may be in other faces.
    if (!seen_from_face(adjacency_, first, strip_.first_face) ||
        !seen_from_face(adjacency_, last, strip_.last_face())) {
      return std::nullopt;
    }
    unfold_strip(adjacency_, strip_, first, last, unfolded_);
    const Vec2 ahead = unfolded_.end - unfolded_.start;
    if (!(norm(ahead) > 0)) return std::nullopt;
    const Vec2 base = unfolded_.first_edges[0];
    const double side = cross(base, -unfolded_.first_edges[2]) < 0 ? -1 : 1;
    const auto [along, inward] =
        FlatFace(adjacency_.mesh(), halfedge(strip_.first_face, 0)).axes(adjacency_.mesh());
    return dot(base, ahead) * along + side * cross(base, ahead) * inward;
  }

 private:
  const Adjacency& adjacency_;
  Poll& poll_;
  FaceStrip strip_;  // memory that is used again, both
  UnfoldedStrip unfolded_;
};

// Whether it is what straightest_geodesic finds.
bool is_straight(const Adjacency& adjacency, const Path& path) {
  for (std::size_t i = 1; i + 1 < path.points.size(); ++i) {
    const SurfacePoint& point = path.points[i].point;
    if (point.at_vertex()) return false;
    const Halfedge under = edge_under(point);
    if (under != kNone && adjacency.ring(adjacency.ring(under)) != under) return false;
  }
  return true;
}

}  // namespace

Vec2 LogMap::coordinates(const Entry& entry, double x_axis) const {
  constexpr double kFullTurn = 2 * std::numbers::pi;
  constexpr double kHardlyAny = 1e-9;  // of faces that are lines
  const bool fills_a_turn = (all_round && total_angle > kHardlyAny) || total_angle > kFullTurn;
  const double scale = fills_a_turn ? kFullTurn / total_angle : 1;
  // A turn of its own first: what is left of an angle beside one of 1e17 is nothing.
  const double angle = scale * entry.angle - std::fmod(scale * x_axis, kFullTurn);
  return {entry.distance * std::cos(angle), entry.distance * std::sin(angle)};
}

SurfacePoint snap_to_edges(const Adjacency& adjacency, const SurfacePoint& point) {
  constexpr double kNear = 1e-6;
  if (point.at_vertex() || point.face == kNone) return point;
  std::array<double, 3> bary = point.bary;
  for (double& weight : bary) {
    if (weight < kNear) weight = 0;
  }
  return point_on_face(adjacency, point.face, bary);
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
  Poll looking(cancel);  // at vertices that are too far
  const std::uint32_t vertex_count = adjacency.mesh().vertex_count();
  // Distances may be above those of the paths by as much as these are refined.
  const double most = radius * kFieldBeyondRadius;
  std::uint64_t count = 0;
  for (std::uint32_t v = 0; v < vertex_count && !looking.cancelled(); ++v) {
    if (field.distance[v] <= most && field.distance[v] != kUnreached) ++count;
  }
  if (looking.stopped()) return fail_stopped(looking);
  if (!poll.may_take(count * sizeof(LogMap::Entry))) return fail_stopped(poll);
  map.entries.reserve(count);
  Departures departures(adjacency, looking);
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (looking.cancelled()) return fail_stopped(looking);
    if (!(field.distance[v] <= most) || field.distance[v] == kUnreached) continue;
    if (poll.cancelled(map.entries.size(), count)) return fail_stopped(poll);
    const auto path =
        path_through(adjacency, field, point_at_vertex(adjacency, v), PathWork::refined, cancel);
    if (!path) return fail(path.error());
    if (!*path || (*path)->length > radius) continue;
    const auto direction = departures.direction_of(**path);
    if (looking.stopped()) return fail_stopped(looking);
    if (!direction) {
      map.entries.push_back({v, (*path)->length, 0, !((*path)->length > 0)});
      continue;
    }
    // Past edges without a length, a way may set out in a face that is not at the point.
    const auto angle = directions->angle_of((*path)->points.front().point.face, *direction);
    map.entries.push_back({v, (*path)->length, angle.value_or(0),
                           angle.has_value() && is_straight(adjacency, **path)});
  }
  return map;
}

}  // namespace geodesic
