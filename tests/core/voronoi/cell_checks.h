// What holds of the cells of any sites.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/voronoi/voronoi.h"
#include "tests/fixtures/surface.h"

namespace geodesic::fixtures {

inline double area_of(const Surface& surface, std::uint32_t f) {
  const Triangle& t = surface.mesh().faces()[f];
  const auto p = surface.mesh().positions();
  return norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])) / 2;
}

// Of the faces that the field comes to as a whole.
inline double reached_area(const Surface& surface, const Field& field) {
  double area = 0;
  for (std::uint32_t f = 0; f < surface.mesh().face_count(); ++f) {
    const Triangle& t = surface.mesh().faces()[f];
    const auto is_reached = [&](std::uint32_t v) { return field.distance[v] != kUnreached; };
    if (std::all_of(t.begin(), t.end(), is_reached)) area += area_of(surface, f);
  }
  return area;
}

// The cells are all of the surface that is reached, by their measures and by their triangles, and
// bisectors and neighbours say the same of each outline.
inline void check_measures(const Surface& surface, const Field& field, const Voronoi& found) {
  const double whole = reached_area(surface, field);
  double sum = 0;
  std::uint64_t vertices = 0;
  for (const VoronoiCell& cell : found.cells) {
    CHECK(cell.area >= 0);
    sum += cell.area;
    vertices += cell.vertices;
  }
  CHECK(std::abs(sum - whole) <= 1e-9 * whole);
  std::uint64_t reached = 0;
  for (const std::uint32_t v : surface.mesh().vertex_of_source()) {
    if (v == kNone) continue;
    const bool is_reached = field.distance[v] != kUnreached;
    reached += is_reached ? 1 : 0;
    CHECK(found.near->is_reached(v) == is_reached);
  }
  CHECK(vertices == reached);

  std::vector<double> outline(found.cells.size());
  for (const NeighbourCells& pair : found.neighbours) {
    CHECK(pair.sites[0] < pair.sites[1]);
    for (const std::uint32_t site : pair.sites) outline[site] += pair.length;
  }
  for (const Bisector& line : found.bisectors.lines) {
    double length = 0;
    for (std::size_t i = 1; i < line.points.size(); ++i) {
      const double step = distance(line.points[i - 1], line.points[i]);
      CHECK(step > 0);
      length += step;
    }
    if (line.closed) length += distance(line.points.back(), line.points.front());
    CHECK(length == doctest::Approx(line.length));
  }
  std::vector<double> drawn(found.cells.size());
  REQUIRE(each_cell_triangle(
      surface.adjacency(), *found.near,
      [&](const CellTriangle& triangle) {
        const auto& t = triangle.corners;
        drawn[triangle.site] += norm(cross(t[1] - t[0], t[2] - t[0])) / 2;
      },
      Cancel()));
  for (std::size_t i = 0; i < found.cells.size(); ++i) {
    CHECK(std::abs(outline[i] - found.cells[i].perimeter) <= 1e-9 * (1 + outline[i]));
    CHECK(std::abs(drawn[i] - found.cells[i].area) <= 1e-7 * (1e-9 + whole));
  }
}

}  // namespace geodesic::fixtures
