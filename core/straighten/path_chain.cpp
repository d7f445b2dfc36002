#include "core/straighten/path_chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include "core/base/vec3.h"
#include "core/straighten/flat_face.h"

namespace geodesic {
namespace {

// The direction from a vertex of a face to a point of it.
DirectionAtVertex direction(const Adjacency& adjacency, std::uint32_t face, std::uint32_t vertex,
                            Vec3 to) {
  const std::uint32_t c = corner_at(adjacency, face, vertex);
  const auto position = [&](std::uint32_t corner) {
    return adjacency.mesh().positions()[adjacency.face(face).vertex[corner]];
  };
  const Vec3 from = position(c);
  const auto angle_to = [&](std::uint32_t corner) {
    const Vec3 edge = position(corner) - from;
    return std::atan2(norm(cross(edge, to - from)), dot(edge, to - from));
  };
  return {face, angle_to(next_corner(c)), angle_to(previous_corner(c))};
}

// Faces that are gone over for one pair of points. A place of a surface has few caps; of a heap of
// them no way is found.
constexpr std::size_t kMostSteps = 4096;
// Of a side: what is nearer to it is on it.
constexpr double kOnSide = 1e-9;

// The place on a side that is closest to a position, if that is where the position is.
std::optional<SurfacePoint> place_on_side(const Adjacency& adjacency, Halfedge side,
                                          Vec3 position) {
  const auto positions = adjacency.mesh().positions();
  const Vec3 tail = positions[adjacency.tail(side)];
  const Vec3 head = positions[adjacency.head(side)];
  const Vec3 along = head - tail;
  if (!(dot(along, along) > 0)) return std::nullopt;
  // Right beside a vertex rather than at it: it goes on into the face across.
  const double t = std::clamp(foot_on_segment(position, tail, head), kOnSide, 1 - kOnSide);
  if (norm(position - tail - t * along) > 2 * kOnSide * norm(along)) return std::nullopt;
  std::array<double, 3> bary{0, 0, 0};
  bary[corner_of(side)] = 1 - t;
  bary[next_corner(corner_of(side))] = t;
  return point_on_face(adjacency, face_of(side), bary);
}

// From one of `starts` over caps into a face of `to`: the start and a place in each face that is
// entered, first where the start is, then where `to` is. None where no caps lead there.
std::vector<PathPoint> over_caps(const Adjacency& adjacency,
                                 const std::vector<SurfacePoint>& starts, Vec3 start,
                                 const PathPoint& to, Poll& poll) {
  struct Step {
    PathPoint at;
    std::size_t before;
    bool is_at_end;
  };
  std::vector<Step> steps;
  std::set<std::pair<std::uint32_t, bool>> entered;
  const auto enter = [&](const SurfacePoint& place, Vec3 position, std::size_t before,
                         bool is_at_end) {
    if (!entered.emplace(place.face, is_at_end).second) return false;
    steps.push_back({{place, position}, before, is_at_end});
    return true;
  };
  for (const SurfacePoint& place : starts) {
    if (steps.size() < kMostSteps) enter(place, start, steps.size(), false);
  }
  const auto way_to = [&](std::size_t step) {
    std::vector<PathPoint> way{steps[step].at};
    while (steps[step].before != step) {
      step = steps[step].before;
      way.push_back(steps[step].at);
    }
    std::reverse(way.begin(), way.end());
    return way;
  };
  for (std::size_t i = 0; i < steps.size(); ++i) {
    for (std::uint32_t turn = steps[i].is_at_end ? 3 : 0; turn < 6; ++turn) {
      if (poll.cancelled()) return {};
      const bool is_at_end = turn >= 3;
      const Vec3 position = is_at_end ? to.position : start;
      const auto on_side =
          place_on_side(adjacency, halfedge(steps[i].at.point.face, turn % 3), position);
      if (!on_side) continue;
      for (const SurfacePoint& there : in_all_faces(adjacency, *on_side)) {
        if (poll.cancelled() || steps.size() == kMostSteps) return {};
        const bool is_there = seen_from_face(adjacency, to.point, there.face).has_value();
        const bool is_cap =
            FlatFace(adjacency.mesh(), halfedge(there.face, 0)).side_under_cap() != kNone;
        if (!(is_there || is_cap) || !enter(there, position, i, is_at_end)) continue;
        if (is_there) return way_to(steps.size() - 1);
      }
    }
  }
  return {};
}

}  // namespace

std::optional<Portal> portal_at(const Adjacency& adjacency, std::uint32_t before,
                                const SurfacePoint& point, Poll& poll) {
  const Halfedge in = edge_under(point);
  if (in == kNone) return std::nullopt;
  for (Halfedge h = adjacency.ring(in); h != in && !poll.cancelled(); h = adjacency.ring(h)) {
    if (face_of(h) == before) return Portal{h, in};
  }
  return std::nullopt;
}

Path with_caps(const Adjacency& adjacency, const SurfacePoint& from, Path path, Poll& poll) {
  std::vector<PathPoint>& points = path.points;
  if (points.empty()) return path;
  std::vector<PathPoint> whole;
  const auto go_over = [&](const std::vector<SurfacePoint>& starts, Vec3 start, const PathPoint& to,
                           std::size_t first) {
    const auto way = over_caps(adjacency, starts, start, to, poll);
    for (std::size_t i = first; i < way.size(); ++i) whole.push_back(way[i]);
  };
  if (!seen_from_face(adjacency, from, points.front().point.face)) {
    go_over(in_all_faces(adjacency, from), points.front().position, points.front(), 0);
  }
  whole.push_back(points.front());
  for (std::size_t i = 1; i < points.size() && !poll.cancelled(); ++i) {
    const SurfacePoint& before = points[i - 1].point;
    if (!seen_from_face(adjacency, points[i].point, before.face)) {
      go_over({before}, points[i - 1].position, points[i], 1);
    }
    whole.push_back(points[i]);
  }
  points = std::move(whole);
  return path;
}

std::optional<Chain> read_chain(const Adjacency& adjacency, const Path& path, Poll& poll) {
  const auto& points = path.points;
  if (points.size() < 2) return std::nullopt;
  Chain chain;
  chain.path_vertices.push_back({points.front().point});
  PathSegment segment;
  segment.strip.first_face = points.front().point.face;
  std::size_t started = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    if (poll.cancelled()) return std::nullopt;
    const std::uint32_t face = points[i].point.face;
    const bool last = i + 2 == points.size();
    const SurfacePoint& next = points[i + 1].point;
    if (face == kNone || !seen_from_face(adjacency, next, face)) return std::nullopt;
    if (!last && !next.at_vertex()) {
      if (next.face == face) continue;
      const auto portal = portal_at(adjacency, face, next, poll);
      if (!portal) return std::nullopt;
      segment.strip.cross(*portal);
      continue;
    }
    const SurfacePoint& start = points[started].point;
    if (start.at_vertex()) {
      segment.leaves = direction(adjacency, start.face, start.vertex, points[started + 1].position);
    }
    if (next.at_vertex())
      segment.arrives = direction(adjacency, face, next.vertex, points[i].position);
    chain.segments.push_back(std::exchange(segment, {}));
    chain.path_vertices.push_back({next});
    segment.strip.first_face = next.face;
    started = i + 1;
  }
  return chain;
}

Path write_path(const Adjacency& adjacency, const Chain& chain, const Path& given) {
  Path path;
  path.source = given.source;
  const auto add = [&](const SurfacePoint& point, Vec3 position) {
    if (!path.points.empty()) {
      if (path.points.back().position == position) {
        path.points.back() = {point, position};
        return;
      }
      path.length += distance(path.points.back().position, position);
    }
    path.points.push_back({point, position});
  };
  const auto seen_from = [&](std::uint32_t face, const SurfacePoint& point) {
    return seen_from_face(adjacency, point, face).value_or(point);
  };
  for (std::size_t i = 0; i < chain.segments.size(); ++i) {
    const PathSegment& segment = chain.segments[i];
    const SurfacePoint start = seen_from(segment.strip.first_face, chain.path_vertices[i].place);
    add(start, i == 0 ? given.points.front().position : position_of(adjacency.mesh(), start));
    for (std::size_t k = 0; k < segment.strip.portals.size(); ++k) {
      const Halfedge in = segment.strip.portals[k].in;
      std::array<double, 3> bary{0, 0, 0};
      bary[corner_of(in)] = 1 - segment.crossings[k];
      bary[next_corner(corner_of(in))] = segment.crossings[k];
      const SurfacePoint point = point_on_face(adjacency, face_of(in), bary);
      add(point, position_of(adjacency.mesh(), point));
    }
  }
  add(seen_from(chain.segments.back().strip.last_face(), chain.path_vertices.back().place),
      given.points.back().position);
  return path;
}

}  // namespace geodesic
