// Closed paths to tighten, and what holds of every loop that was.
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/locate/plane_section.h"
#include "core/paths/join_paths.h"
#include "core/straighten/loop_straightness.h"
#include "core/straighten/tighten_loop.h"
#include "tests/fixtures/locally_shortest.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/surface.h"

namespace geodesic::loops {

inline double unit_of(std::mt19937& random) { return random() / 4294967296.0; }

inline Vec3 any_direction(std::mt19937& random) {
  while (true) {
    const Vec3 v{unit_of(random) - 0.5, unit_of(random) - 0.5, unit_of(random) - 0.5};
    if (norm(v) > 0.1 && norm(v) < 0.5) return (1 / norm(v)) * v;
  }
}

// Turned, scaled and moved at random: what has a closed form keeps it, times `scale`.
struct Placed {
  Vec3 x, y, z, origin;
  double scale = 1;

  explicit Placed(std::mt19937& random) {
    x = any_direction(random);
    y = cross(x, any_direction(random));
    y = (1 / norm(y)) * y;
    z = cross(x, y);
    origin = 3 * any_direction(random);
    scale = std::pow(10.0, 2 * unit_of(random) - 1);
  }
  [[nodiscard]] Vec3 direction(Vec3 p) const { return p.x * x + p.y * y + p.z * z; }
  [[nodiscard]] TriangleSoup place(TriangleSoup soup) const {
    for (Vec3& p : soup.positions) p = origin + scale * direction(p);
    return soup;
  }
};

inline std::optional<Path> section_of(const fixtures::Surface& surface, const SurfacePoint& at,
                                      Vec3 normal) {
  const auto section = plane_section(surface.adjacency(), at, normal, Cancel());
  if (!section) {
    CHECK(section.error().code == ErrorCode::no_loop);
    return std::nullopt;
  }
  return closed_path_along(surface.mesh(), *section);
}

// Round by shortest edges: a path along shortest paths, and back to the first.
inline std::optional<Path> round_by(const fixtures::Surface& surface,
                                    const std::vector<std::uint32_t>& vertices) {
  std::vector<Path> legs;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const SurfacePoint from = surface.at(vertices[i]);
    const SurfacePoint to = surface.at(vertices[(i + 1) % vertices.size()]);
    auto leg = surface.path(surface.field_by(Method::dijkstra, {Source{from, 0}}), to);
    if (!leg) return std::nullopt;
    legs.push_back(std::move(*leg));
  }
  return join_paths(legs);
}

// The same loop one and a half times, so that every point of it is inside; less the points on edges
// that are within rounding of the vertex behind or before them, which say no direction.
inline Path one_and_a_half(const Path& loop) {
  Path longer = loop;
  longer.points.back() = loop.points.front();  // in the face of the segment that leaves it
  const std::size_t half = loop.points.size() / 2 + 1;
  for (std::size_t i = 1; i < loop.points.size() && i <= half; ++i) {
    longer.points.push_back(loop.points[i]);
  }
  Path clear;
  for (std::size_t i = 0; i < longer.points.size(); ++i) {
    const PathPoint& point = longer.points[i];
    const auto is_vertex_at = [&](std::size_t k) {
      return k < longer.points.size() && longer.points[k].point.at_vertex() &&
             distance(point.position, longer.points[k].position) <= 1e-12 * loop.length;
    };
    if (!point.point.at_vertex() && is_vertex_at(i + 1)) continue;
    if (!point.point.at_vertex() && is_vertex_at(i - 1)) {
      clear.points.back().point.face = point.point.face;
      continue;
    }
    clear.points.push_back(point);
  }
  return clear;
}

// What holds for every loop that was tightened.
inline void check_tight(const fixtures::Surface& surface, const Path& start,
                        const TightLoop& tight) {
  const Path& loop = tight.path;
  const Box& box = surface.mesh().box();
  fixtures::check_is_a_path(surface.adjacency(), loop, distance(box.min, box.max));
  REQUIRE(loop.points.size() >= 2);
  CHECK(loop.points.front().position == loop.points.back().position);
  CHECK(loop.length <= start.length);
  const auto straightness = straightness_of_loop(surface.adjacency(), loop, Cancel());
  REQUIRE(straightness);
  CHECK(tight.is_finished == straightness->is_known);
}

inline void check_is_geodesic(const fixtures::Surface& surface, const Path& loop) {
  const auto bend = fixtures::worst_bend(surface.adjacency(), one_and_a_half(loop), 1e-4);
  CHECK(bend.at_edges <= 1e-6);
  CHECK(bend.at_vertices <= 1e-6);
  const auto straightness = straightness_of_loop(surface.adjacency(), loop, Cancel());
  REQUIRE(straightness);
  CHECK(straightness->lack <= 1e-6);
}

inline TightLoop tight(const fixtures::Surface& surface, const Path& start) {
  const auto tight = tighten_loop(surface.adjacency(), start, Cancel());
  REQUIRE(tight);
  check_tight(surface, start, *tight);
  return *tight;
}

inline double polygon(std::uint32_t n, double radius) {
  return 2 * n * radius * std::sin(std::numbers::pi / n);
}

}  // namespace geodesic::loops
