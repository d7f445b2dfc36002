#include "core/straighten/log_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "core/straighten/directions_at.h"
#include "core/straighten/face_strip.h"
#include "core/straighten/flat_face.h"
#include "core/straighten/path_chain.h"
#include "core/straighten/straightest_geodesic.h"

namespace geodesic {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;

// Turned about the normal of a face in whose plane it lies, counter-clockwise by the face's
// winding.
Vec3 turned(const Adjacency& adjacency, std::uint32_t face, Vec3 direction, double angle) {
  const auto [along, inward] = FlatFace(adjacency.mesh(), halfedge(face, 0)).axes(adjacency);
  const double x = dot(direction, along);
  const double y = dot(direction, inward);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return (c * x - s * y) * along + (s * x + c * y) * inward;
}

// What a path is between two vertices, or a vertex and an end: straight, over a strip of faces.
class StraightPiece {
 public:
  StraightPiece(const Adjacency& adjacency, Poll& poll) : adjacency_(adjacency), poll_(poll) {}

  // Unfolds the faces from that point of the path to the next vertex or the end. Whether there is a
  // direction: none of a path without a length, nor where edges without a length leave none. Of no
  // use if the poll says to stop.
  bool unfold(const Path& path, std::size_t begin) {
    strip_.first_face = path.points[begin].point.face;
    strip_.portals.clear();
    is_whole_ = true;
    end_ = begin + 1;
    for (; end_ + 1 < path.points.size() && !path.points[end_].point.at_vertex(); ++end_) {
      const SurfacePoint& point = path.points[end_].point;
      const std::uint32_t before = path.points[end_ - 1].point.face;
      if (point.face == before) continue;
      const auto portal = portal_at(adjacency_, before, point, poll_);
      is_whole_ = portal.has_value();
      if (!portal) break;
      strip_.cross(*portal);
    }
    if (end_ >= path.points.size()) return false;
    const SurfacePoint& first = path.points[begin].point;
    const SurfacePoint& last = path.points[end_].point;
    // Past edges without a length they may be in other faces.
    if (!seen_from_face(adjacency_, first, strip_.first_face) ||
        !seen_from_face(adjacency_, last, strip_.last_face())) {
      return false;
    }
    unfold_strip(adjacency_, strip_, first, last, unfolded_);
    ahead_ = unfolded_.end - unfolded_.start;
    return norm(ahead_) > 0;
  }

  // Of the point that it ends at, in the path.
  [[nodiscard]] std::size_t end() const { return end_; }
  // Whether that is a vertex or the path's end.
  [[nodiscard]] bool is_whole() const { return is_whole_; }
  [[nodiscard]] std::uint32_t first_face() const { return strip_.first_face; }
  [[nodiscard]] std::uint32_t last_face() const { return strip_.last_face(); }
  // Where it leads, in the plane of its first and of its last face, told by the end of all that is
  // straight: a first segment may be as short as rounding leaves it. As long as it is.
  [[nodiscard]] Vec3 ahead_in_first() const {
    return Frame(adjacency_, first_face(), unfolded_.first_edges, unfolded_.first_sense)
        .in_space(ahead_);
  }
  [[nodiscard]] Vec3 ahead_in_last() const {
    return Frame(adjacency_, last_face(), unfolded_.last_edges, unfolded_.last_sense)
        .in_space(ahead_);
  }
  // A direction in the plane of the first face, in that of the last one, once all is unfolded.
  [[nodiscard]] Vec3 carried(Vec3 direction) const {
    const Frame first(adjacency_, first_face(), unfolded_.first_edges, unfolded_.first_sense);
    return Frame(adjacency_, last_face(), unfolded_.last_edges, unfolded_.last_sense)
        .in_space(first.unfolded(direction));
  }

 private:
  // A face in space, and where it lies once it is unfolded.
  struct Frame {
    Frame(const Adjacency& adjacency, std::uint32_t face, const std::array<Vec2, 3>& edges,
          double sense)
        : base(edges[0]), side(sense) {
      std::tie(along, inward) = FlatFace(adjacency.mesh(), halfedge(face, 0)).axes(adjacency);
    }
    [[nodiscard]] Vec3 in_space(Vec2 v) const {
      return dot(base, v) * along + side * cross(base, v) * inward;
    }
    [[nodiscard]] Vec2 unfolded(Vec3 v) const {
      return dot(v, along) * base + side * dot(v, inward) * Vec2{-base.y, base.x};
    }

    Vec2 base;
    double side;
    Vec3 along;
    Vec3 inward;
  };

  const Adjacency& adjacency_;
  Poll& poll_;
  FaceStrip strip_;  // memory that is used again, both
  UnfoldedStrip unfolded_;
  Vec2 ahead_;
  std::size_t end_ = 0;
  bool is_whole_ = true;
};

// Carries directions along paths from one point.
class Transport {
 public:
  Transport(const Adjacency& adjacency, const DirectionsAt& at_point, double angle,
            const Cancel& cancel)
      : adjacency_(adjacency), at_point_(at_point), angle_(angle), cancel_(cancel) {}

  // Along a path whose first piece is unfolded; zero where it cannot be. Errors: cancelled, also
  // as the poll of the piece has it.
  Result<Vec3> along(const Path& path, StraightPiece& piece, Poll& poll) {
    const auto departs = at_point_.angle_of(piece.first_face(), piece.ahead_in_first());
    const auto sense = at_point_.sense_of(piece.first_face());
    if (!departs || !sense) return Vec3{};
    double off = std::fmod(at_point_.scale() * angle_, kFullTurn) - at_point_.scale() * *departs;
    for (int way = *sense;;) {
      if (!piece.is_whole()) return Vec3{};
      const Vec3 direction =
          turned(adjacency_, piece.first_face(), piece.ahead_in_first(), way * off);
      if (piece.end() + 1 == path.points.size()) {
        const Vec3 arrived = piece.carried(direction);
        const double length = norm(arrived);
        return length > 0 ? (1 / length) * arrived : Vec3{};
      }
      const SurfacePoint& passed = path.points[piece.end()].point;
      if (auto looked = look_round(passed.vertex); !looked) return fail(looked.error());
      if (!round_vertex_) return Vec3{};
      const std::uint32_t before = piece.last_face();
      const auto back = round_vertex_->angle_of(before, -1 * piece.ahead_in_last());
      const auto sense_before = round_vertex_->sense_of(before);
      const double here = angle_to(before, piece.ahead_in_last(), piece.carried(direction));
      const bool goes_on = piece.unfold(path, piece.end());
      if (poll.stopped()) return fail_stopped(poll);
      const auto out = goes_on ? round_vertex_->angle_of(piece.first_face(), piece.ahead_in_first())
                               : std::nullopt;
      const auto sense_behind = round_vertex_->sense_of(piece.first_face());
      if (!back || !out || !sense_before || !sense_behind) return Vec3{};
      off = round_vertex_->scale() * (*back - *out) + std::numbers::pi + *sense_before * here;
      way = *sense_behind;
    }
  }

 private:
  // Of b from a, both in the plane of the face, counter-clockwise by its winding.
  [[nodiscard]] double angle_to(std::uint32_t face, Vec3 a, Vec3 b) const {
    const auto [along, inward] = FlatFace(adjacency_.mesh(), halfedge(face, 0)).axes(adjacency_);
    const Vec2 from{dot(a, along), dot(a, inward)};
    const Vec2 to{dot(b, along), dot(b, inward)};
    return std::atan2(cross(from, to), dot(from, to));
  }

  // Paths that follow each other often pass the same vertex.
  Result<void> look_round(std::uint32_t vertex) {
    if (vertex == vertex_) return {};
    vertex_ = vertex;
    round_vertex_.reset();
    auto found = DirectionsAt::of(adjacency_, point_at_vertex(adjacency_, vertex), cancel_);
    if (found) {
      round_vertex_ = std::move(*found);
    } else if (found.error().code != ErrorCode::value_out_of_range) {
      return fail(std::move(found.error()));
    }
    return {};
  }

  const Adjacency& adjacency_;
  const DirectionsAt& at_point_;
  double angle_;
  const Cancel& cancel_;
  std::uint32_t vertex_ = kNone;
  std::optional<DirectionsAt> round_vertex_;  // none: the faces there are no fan
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

// Where straightest_geodesic_at_angle sets out; zero where no face has the angle.
Result<Vec3> direction_there(const Adjacency& adjacency, const SurfacePoint& from, double angle,
                             const Cancel& cancel) {
  auto going = straightest_geodesic_at_angle(adjacency, from, angle, 0, cancel);
  if (going) return going->direction_at_end;
  if (going.error().code == ErrorCode::value_out_of_range) return Vec3{};
  return fail(std::move(going.error()));
}

}  // namespace

Vec2 LogMap::coordinates(const Entry& entry, double x_axis) const {
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
                       double radius, const Cancel& cancel, std::optional<double> carried) {
  const auto directions = DirectionsAt::of(adjacency, from, cancel);
  if (!directions) return fail(directions.error());
  LogMap map;
  map.total_angle = directions->total();
  map.all_round = directions->all_round();
  map.scale = directions->scale();
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
  const std::uint64_t each = sizeof(LogMap::Entry) + (carried ? sizeof(Vec3) : 0);
  if (!poll.may_take(count * each)) return fail_stopped(poll);
  map.entries.reserve(count);
  if (carried) map.directions.reserve(count);
  StraightPiece piece(adjacency, looking);
  Transport transport(adjacency, *directions, carried.value_or(0), cancel);
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (looking.cancelled()) return fail_stopped(looking);
    if (!(field.distance[v] <= most) || field.distance[v] == kUnreached) continue;
    if (poll.cancelled(map.entries.size(), count)) return fail_stopped(poll);
    auto path =
        path_through(adjacency, field, point_at_vertex(adjacency, v), PathWork::refined, cancel);
    if (!path) return fail(path.error());
    if (!*path || (*path)->length > radius) continue;
    **path = without_gaps(adjacency, from, std::move(**path), looking);
    const bool has_direction = piece.unfold(**path, 0);
    if (looking.stopped()) return fail_stopped(looking);
    const bool is_there = !((*path)->length > 0);
    if (!has_direction) {
      map.entries.push_back({v, (*path)->length, 0, is_there});
    } else {
      // Past edges without a length, a way may set out in a face that is not at the point.
      const auto angle = directions->angle_of(piece.first_face(), piece.ahead_in_first());
      map.entries.push_back({v, (*path)->length, angle.value_or(0),
                             angle.has_value() && is_straight(adjacency, **path)});
    }
    if (!carried) continue;
    auto arrived = has_direction ? transport.along(**path, piece, looking)
                   : is_there    ? direction_there(adjacency, from, *carried, cancel)
                                 : Result<Vec3>(Vec3{});
    if (!arrived) return fail(std::move(arrived.error()));
    map.directions.push_back(*arrived);
  }
  return map;
}

}  // namespace geodesic
