#include "core/straighten/path_chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/base/vec3.h"
#include "core/surface/line_gaps.h"

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

// Whether a path goes from one point to the next within the face of the first.
bool leads_on(const Adjacency& adjacency, const SurfacePoint& from, const SurfacePoint& to) {
  return from.face != kNone && seen_from_face(adjacency, to, from.face).has_value();
}

bool has_gap(const Adjacency& adjacency, const std::vector<PathPoint>& points) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    if (!leads_on(adjacency, points[i].point, points[i + 1].point)) return true;
  }
  return false;
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

Path without_gaps(const Adjacency& adjacency, const SurfacePoint& from, Path path, Poll& poll) {
  std::vector<PathPoint>& points = path.points;
  if (points.empty()) return path;
  const bool is_elsewhere = !seen_from_face(adjacency, from, points.front().point.face);
  if (!is_elsewhere && !has_gap(adjacency, points)) return path;
  std::vector<SurfacePoint> line;
  line.reserve(points.size() + 1);
  if (is_elsewhere) line.push_back(from);
  for (const PathPoint& point : points) line.push_back(point.point);
  line = close_gaps(adjacency, line, Gaps::beside_vertices, poll);
  std::vector<PathPoint> whole;
  whole.reserve(line.size());
  for (std::size_t i = 0; i < line.size() && !poll.cancelled(); ++i) {
    PathPoint point{line[i], position_of(adjacency.mesh(), line[i])};
    if (i + 1 < line.size() && !leads_on(adjacency, line[i], line[i + 1])) {
      const std::uint32_t face = face_in_common(adjacency, line[i], line[i + 1], poll);
      if (face != kNone) point.point = *seen_from_face(adjacency, line[i], face);
    }
    whole.push_back(point);
  }
  points = std::move(whole);
  return path;
}

std::optional<Chain> read_chain(const Adjacency& adjacency, const Path& path, Poll& poll) {
  if (path.points.size() < 2) return std::nullopt;
  if (has_gap(adjacency, path.points)) {
    const Path whole = without_gaps(adjacency, path.points.front().point, path, poll);
    if (poll.stopped() || has_gap(adjacency, whole.points)) return std::nullopt;
    return read_chain(adjacency, whole, poll);
  }
  const auto& points = path.points;
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
