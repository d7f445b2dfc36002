#include "core/straighten/straightest_geodesic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/tolerances.h"
#include "core/base/vec2.h"
#include "core/straighten/flat_face.h"
#include "core/straighten/vertex_fan.h"

namespace geodesic {
namespace {

using End = StraightestGeodesic::End;
using Weights = std::array<double, 3>;

// A point about to leave through a face in a direction of that face's plane.
struct Departure {
  Halfedge base;  // the frame that `heading` is in, see FlatFace
  Weights at;     // of the corners of the frame
  Vec2 heading;   // unit
};

class Walk {
 public:
  Walk(const Adjacency& adjacency, const Cancel& cancel)
      : adjacency_(adjacency), mesh_(adjacency.mesh()), poll_(cancel) {}

  Result<StraightestGeodesic> go(Departure here, double length) {
    double left = length;
    for (std::uint64_t faces = 0;; ++faces) {
      // Passing a vertex counts as one face, however many it has: those are polled.
      if (poll_.cancelled()) return fail_stopped(poll_);
      if (faces == kMostFacesCrossed) {
        return fail_limit(ErrorCode::too_large, "the geodesic crosses too many faces",
                          kMostFacesCrossed, faces + 1, "length");
      }
      const FlatFace flat(mesh_, here.base);
      const SurfacePoint point = flat.point(adjacency_, here.at);
      if (result_.path.points.empty()) {
        add(point, position_of(mesh_, point));
      } else {
        result_.path.points.back().point = point;  // the same place, in this face
      }
      if (!(left > 0)) return finish(flat, here.heading, End::length);

      const Exit leaves = exit(flat, here);
      Weights out{0, 0, 0};
      out[leaves.side] = leaves.of_tail;
      out[next_corner(leaves.side)] = leaves.of_head;
      const SurfacePoint there = flat.point(adjacency_, out);
      const Vec3 position = position_of(mesh_, there);
      const double step = distance(result_.path.points.back().position, position);
      if (step > left) {
        const double s = left / step;
        for (std::size_t i = 0; i < 3; ++i) out[i] = (1 - s) * here.at[i] + s * out[i];
        const SurfacePoint end = flat.point(adjacency_, out);
        add(end, position_of(mesh_, end));
        return finish(flat, here.heading, End::length);
      }
      left -= step;
      add(there, position);
      if (left <= tolerance::kMissingLength * length)
        return finish(flat, here.heading, End::length);
      const auto next = there.at_vertex() ? over_vertex(flat, there.vertex, here.heading)
                                          : over_edge(flat, leaves, here.heading);
      if (poll_.stopped()) return fail_stopped(poll_);
      if (!next) return finish(flat, here.heading, next.error());
      here = *next;
    }
  }

  // A point on a side, by the weights of its ends. Both, for one may be far below the rounding
  // of the other.
  struct Exit {
    std::uint32_t side;
    double of_tail;
    double of_head;
    double ahead = 0;  // of the point, in the direction of the heading
  };

  // The departure in the face beyond a side, or why there is none.
  tl::expected<Departure, End> over_edge(const FlatFace& flat, const Exit& at, Vec2 heading) const {
    const Halfedge out = flat.side(at.side);
    const Halfedge in = adjacency_.ring(out);
    if (in == out) return tl::unexpected(End::boundary);
    if (adjacency_.ring(in) != out) return tl::unexpected(End::non_manifold);
    const bool same_way = vertex_at(in) == vertex_at(out);
    const double along = dot(heading, flat.edges[at.side]);
    const double outward = std::max(-cross(flat.edges[at.side], heading), 0.0);
    return Departure{
        in, same_way ? Weights{at.of_tail, at.of_head, 0} : Weights{at.of_head, at.of_tail, 0},
        unit({same_way ? along : -along, outward})};
  }

  // A departure from a vertex: into the face of `corner`, turned by `angle` from the
  // edge to the next corner.
  static Departure from_corner(Halfedge corner, double angle) {
    return {corner, {1, 0, 0}, {std::cos(angle), std::sin(angle)}};
  }

  // Turns on through a fan of faces: by `angle`, from the edge `side` at the vertex
  // into the side's own face and on. At a boundary or non-manifold edge, why it ends.
  // The face that it is in then does not matter, if the poll says to stop.
  tl::expected<Departure, End> turn(std::uint32_t vertex, Halfedge side, double angle) {
    for (std::size_t faces = adjacency_.corners(vertex).size();; --faces) {
      const std::uint32_t f = face_of(side);
      const bool is_next = vertex_at(side) == vertex;
      const Halfedge other = other_side_at(adjacency_, side, vertex);
      const Halfedge corner = is_next ? side : other;
      const double here = corner_angle(adjacency_.face(f), corner_of(corner));
      if (angle <= here) return from_corner(corner, is_next ? angle : here - angle);
      angle -= here;
      const Halfedge across = adjacency_.ring(other);
      if (across == other || adjacency_.ring(across) != other) {
        if (angle <= tolerance::kFanEnd) return from_corner(corner, is_next ? here : 0);
        return tl::unexpected(across == other ? End::boundary : End::non_manifold);
      }
      // Once round a closed fan: what is left of the angle is a rounding error.
      if (faces <= 1 || poll_.cancelled()) return from_corner(corner, is_next ? here : 0);
      side = across;
    }
  }

  // The sum of all angles at a vertex, when they make one closed fan; if not, what is
  // in the way.
  [[nodiscard]] tl::expected<double, End> total_angle(std::uint32_t vertex) {
    if (adjacency_.is_pinched(vertex)) return tl::unexpected(End::vertex);
    double sum = 0;
    std::optional<End> obstacle;
    for (const std::uint32_t corner : adjacency_.corners(vertex)) {
      if (poll_.cancelled()) break;
      sum += corner_angle(adjacency_.face(face_of(corner)), corner_of(corner));
      for (const Halfedge side : {corner, other_side_at(adjacency_, corner, vertex)}) {
        const Halfedge across = adjacency_.ring(side);
        if (adjacency_.ring(across) != side) obstacle = End::non_manifold;
        if (across == side && !obstacle) obstacle = End::boundary;
      }
    }
    if (obstacle) return tl::unexpected(*obstacle);
    return sum;
  }

  [[nodiscard]] std::uint32_t vertex_at(Halfedge h) const {
    return adjacency_.face(face_of(h)).vertex[corner_of(h)];
  }

  // The start alone, with the direction in which it would go.
  StraightestGeodesic only(const SurfacePoint& point, const FlatFace& flat, Vec2 heading, End end) {
    add(point, position_of(mesh_, point));
    return finish(flat, heading, end);
  }

 private:
  // The side by which a heading leaves the face. A ray leaves between a corner to its
  // right and the next one to its left.
  static Exit exit(const FlatFace& flat, const Departure& here) {
    const std::array<Vec2, 3> to = flat.to_corners(here.at);
    const auto left = [&](std::uint32_t i) { return cross(here.heading, to[i]); };
    const auto by = [&](std::uint32_t side) {
      const std::uint32_t end = next_corner(side);
      const double before = std::max(-left(side), 0.0);
      const double behind = std::max(left(end), 0.0);
      const double ahead[2] = {dot(here.heading, to[side]), dot(here.heading, to[end])};
      Exit exit{side, 1, 0};
      if (before + behind > 0) {
        exit.of_tail = behind / (before + behind);
        exit.of_head = before / (before + behind);
      } else if (ahead[1] > ahead[0]) {
        exit = {side, 0, 1};  // along the side, to the end that lies farther on
      }
      if (exit.of_head < tolerance::kAtVertex &&
          before <= tolerance::kPassesVertex * norm(to[side]))
        exit = {side, 1, 0};
      if (exit.of_tail < tolerance::kAtVertex && behind <= tolerance::kPassesVertex * norm(to[end]))
        exit = {side, 0, 1};
      exit.ahead = exit.of_tail * ahead[0] + exit.of_head * ahead[1];
      return exit;
    };
    // From the tail of the base, by the side opposite; from elsewhere on the base, not
    // by the base again.
    if (here.at[2] == 0) {
      const double apex = left(2);
      const bool by_first = apex > 0 || (apex == 0 && here.heading.x >= 0);
      return by(here.at[1] == 0 || by_first ? 1 : 2);
    }
    Exit best{0, 1, 0, -std::numeric_limits<double>::infinity()};
    for (std::uint32_t side = 0; side < 3; ++side) {
      if (left(side) > 0 || left(next_corner(side)) < 0) continue;
      const Exit found = by(side);
      if (found.ahead > best.ahead) best = found;
    }
    return best;
  }

  // Half of the vertex's angle, counted from where the line came from.
  tl::expected<Departure, End> over_vertex(const FlatFace& flat, std::uint32_t vertex,
                                           Vec2 heading) {
    const auto total = total_angle(vertex);
    if (!total) return tl::unexpected(total.error());
    std::uint32_t i = 0;
    while (adjacency_.face(flat.face).vertex[flat.corner(i)] != vertex) ++i;
    const Halfedge corner = flat.side(i);
    const double to_next = angle_between(flat.edges[i], -heading);
    const double half = *total / 2;
    if (half <= to_next) return from_corner(corner, to_next - half);
    return turn(vertex, adjacency_.ring(corner), half - to_next);
  }

  void add(const SurfacePoint& point, Vec3 position) {
    Path& path = result_.path;
    if (!path.points.empty()) {
      if (path.points.back().position == position) {
        path.points.back() = {point, position};
        return;
      }
      path.length += distance(path.points.back().position, position);
    }
    path.points.push_back({point, position});
  }

  StraightestGeodesic finish(const FlatFace& flat, Vec2 heading, End end) {
    const auto [along, inward] = flat.axes(adjacency_);
    const Vec3 direction = heading.x * along + heading.y * inward;
    const double size = norm(direction);
    result_.direction_at_end = size > 0 ? (1 / size) * direction : along;
    result_.end = end;
    return std::move(result_);
  }

  const Adjacency& adjacency_;
  const Mesh& mesh_;
  Poll poll_;
  StraightestGeodesic result_;
};

// A direction on the surface and how close it is to a vector in space.
struct Candidate {
  double closeness = -2;  // the cosine of the angle between them
  bool points_inside = false;
  Halfedge edge = kNone;  // when it does not: the edge that it was turned to
  Departure departure{};
  Vec2 projection;           // of the vector onto the face's plane, in the departure's frame
  bool at_boundary = false;  // whether the point is on a side of the face that is boundary
};

// In one face, at a point that is its corner, on its side or inside it.
Candidate closest_in_face(const Adjacency& adjacency, const SurfacePoint& place, Vec3 vector) {
  const Halfedge under = edge_under(place);
  const bool inside = under == kNone && !place.at_vertex();
  const std::uint32_t base = inside              ? 0
                             : place.at_vertex() ? corner_at(adjacency, place.face, place.vertex)
                                                 : corner_of(under);
  const FlatFace flat(adjacency.mesh(), halfedge(place.face, base));
  const auto [along, inward] = flat.axes(adjacency);
  const Vec2 projected{dot(vector, along), dot(vector, inward)};

  Candidate candidate;
  candidate.projection = projected;
  candidate.departure.base = flat.side(0);
  for (std::uint32_t i = 0; i < 3; ++i) candidate.departure.at[i] = place.bary[flat.corner(i)];
  const auto is_boundary = [&](std::uint32_t i) {
    return adjacency.ring(flat.side(i)) == flat.side(i);
  };
  candidate.at_boundary = !inside && (is_boundary(0) || (place.at_vertex() && is_boundary(2)));
  // The cone of directions into the face reaches from `low` counterclockwise to `high`.
  const Vec2 low{1, 0};
  const Vec2 high = place.at_vertex() ? -flat.edges[2] : Vec2{-1, 0};
  candidate.points_inside = inside || (cross(low, projected) >= -tolerance::kNoProjection &&
                                       cross(projected, high) >= -tolerance::kNoProjection &&
                                       dot(projected, low + high) >= -tolerance::kNoProjection);
  if (candidate.points_inside) {
    candidate.closeness = norm(projected);
    candidate.departure.heading = unit(projected);
    if (!inside) candidate.departure.heading.y = std::max(candidate.departure.heading.y, 0.0);
  } else {
    const bool to_low = dot(projected, low) >= dot(projected, high);
    candidate.closeness = dot(projected, to_low ? low : high);
    candidate.departure.heading = to_low ? low : high;
    candidate.edge = to_low || !place.at_vertex() ? flat.side(0) : flat.side(2);
  }
  return candidate;
}

Result<void> check(const SurfacePoint& from, double length) {
  if (from.face == kNone) {
    return fail(ErrorCode::value_out_of_range, "the point is at a vertex of no face", "from");
  }
  if (!std::isfinite(length) || length < 0) {
    return fail(ErrorCode::value_out_of_range, "the length must be finite and not negative",
                "length");
  }
  return {};
}

}  // namespace

Result<StraightestGeodesic> straightest_geodesic(const Adjacency& adjacency,
                                                 const SurfacePoint& from, Vec3 direction,
                                                 double length, const Cancel& cancel) {
  if (auto checked = check(from, length); !checked) return fail(checked.error());
  if (!std::isfinite(direction.x) || !std::isfinite(direction.y) || !std::isfinite(direction.z)) {
    return fail(ErrorCode::value_out_of_range, "the direction is not finite", "direction");
  }
  const double largest =
      std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
  if (largest == 0) {
    return fail(ErrorCode::value_out_of_range, "the direction is zero", "direction");
  }
  // Divided by the largest first: its square may be too large or too small.
  Vec3 vector{direction.x / largest, direction.y / largest, direction.z / largest};
  vector = (1 / norm(vector)) * vector;

  Candidate best;
  Poll poll(cancel);
  double longest_projection = 0;
  bool at_boundary = false;
  for (const SurfacePoint& place : in_all_faces(adjacency, from)) {
    if (poll.cancelled()) return fail_stopped(poll);
    const Candidate candidate = closest_in_face(adjacency, place, vector);
    longest_projection = std::max(longest_projection, norm(candidate.projection));
    at_boundary = at_boundary || candidate.at_boundary;
    if (candidate.closeness > best.closeness) best = candidate;
  }
  const auto vanishes = [] {
    return fail(ErrorCode::value_out_of_range, "the direction is at a right angle to the surface",
                "direction");
  };
  if (longest_projection <= tolerance::kNoProjection) return vanishes();
  Walk walk(adjacency, cancel);
  if (at_boundary && !best.points_inside &&
      (best.closeness <= tolerance::kNoProjection || adjacency.ring(best.edge) == best.edge)) {
    const FlatFace flat(adjacency.mesh(), best.departure.base);
    return walk.only(from, flat, best.projection, End::boundary);
  }
  if (best.closeness <= tolerance::kNoProjection) return vanishes();
  return walk.go(best.departure, length);
}

Result<StraightestGeodesic> straightest_geodesic_at_angle(const Adjacency& adjacency,
                                                          const SurfacePoint& from, double angle,
                                                          double length, const Cancel& cancel) {
  if (auto checked = check(from, length); !checked) return fail(checked.error());
  if (!std::isfinite(angle)) {
    return fail(ErrorCode::value_out_of_range, "the angle is not finite", "angle");
  }
  Walk walk(adjacency, cancel);
  if (from.at_vertex()) {
    const Halfedge corner = adjacency.corners(from.vertex).front();
    Poll poll(cancel);
    const auto total = closed_fan_angle(adjacency, corner, poll);
    if (total && *total > 0) {
      angle = std::fmod(angle, *total);
      if (angle < 0) angle += *total;
    }
    // The other way round begins in the face across the first edge.
    const Halfedge across = adjacency.ring(corner);
    const bool manifold = across != corner && adjacency.ring(across) == corner;
    if (poll.stopped()) return fail_stopped(poll);
    const auto departure = angle >= -tolerance::kFanEnd
                               ? walk.turn(from.vertex, corner, std::max(angle, 0.0))
                           : manifold ? walk.turn(from.vertex, across, -angle)
                                      : tl::expected<Departure, End>(tl::unexpected(End::boundary));
    if (!departure) {
      return fail(ErrorCode::value_out_of_range, "no face at the vertex has this angle", "angle");
    }
    return walk.go(*departure, length);
  }

  const FlatFace flat(adjacency.mesh(), halfedge(from.face, 0));
  const Vec2 heading{std::cos(angle), std::sin(angle)};
  const Halfedge under = edge_under(from);
  if (under == kNone) return walk.go({halfedge(from.face, 0), from.bary, heading}, length);
  const std::uint32_t side = corner_of(under);
  const Walk::Exit at{side, from.bary[side], from.bary[next_corner(side)]};
  const double inward = cross(flat.edges[side], heading);
  if (inward >= -tolerance::kNoProjection) {
    return walk.go({halfedge(from.face, side),
                    {at.of_tail, at.of_head, 0},
                    unit({dot(heading, flat.edges[side]), std::max(inward, 0.0)})},
                   length);
  }
  const auto departure = walk.over_edge(flat, at, heading);
  if (departure) return walk.go(*departure, length);
  return walk.only(from, flat, heading, departure.error());
}

}  // namespace geodesic
