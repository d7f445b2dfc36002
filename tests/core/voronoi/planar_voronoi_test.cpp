// Cells in the plane against half-planes cut from a polygon one after the other.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "core/base/vec2.h"
#include "core/mesh/shapes.h"
#include "core/voronoi/voronoi.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

// A convex polygon, with what each of its sides is against; -1: the border.
struct Cell {
  std::vector<Vec2> corners;
  std::vector<int> sides;  // from each corner to the next

  [[nodiscard]] double area() const {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      sum += cross(corners[i], corners[(i + 1) % corners.size()]) / 2;
    }
    return sum;
  }
  [[nodiscard]] Vec2 centroid() const {
    Vec2 sum;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 a = corners[i];
      const Vec2 b = corners[(i + 1) % corners.size()];
      sum = sum + cross(a, b) / 6 * (a + b);
    }
    return 1 / area() * sum;
  }
  [[nodiscard]] double length_against(int other) const {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (sides[i] == other) sum += norm(corners[(i + 1) % corners.size()] - corners[i]);
    }
    return sum;
  }

  // Keeps what is nearer to a than to b.
  void cut(Vec2 a, Vec2 b, int number) {
    const auto excess = [&](Vec2 p) { return dot(p - 0.5 * (a + b), b - a); };
    Cell kept;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 p = corners[i];
      const Vec2 q = corners[(i + 1) % corners.size()];
      const double at_p = excess(p);
      const double at_q = excess(q);
      if (at_p <= 0) {
        kept.corners.push_back(p);
        kept.sides.push_back(sides[i]);
      }
      if ((at_p <= 0) == (at_q <= 0)) continue;
      kept.corners.push_back(p + at_p / (at_p - at_q) * (q - p));
      kept.sides.push_back(at_p <= 0 ? number : sides[i]);
    }
    *this = kept;
  }
};

std::vector<Cell> planar_cells(double width, double height, const std::vector<Vec2>& sites) {
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < sites.size(); ++i) {
    Cell cell{{{0, 0}, {width, 0}, {width, height}, {0, height}}, {-1, -1, -1, -1}};
    for (std::size_t j = 0; j < sites.size(); ++j) {
      if (j != i) cell.cut(sites[i], sites[j], static_cast<int>(j));
    }
    cells.push_back(cell);
  }
  return cells;
}

struct Plane {
  Surface surface;
  double width;
  double height;
};

// A rectangle whose inner vertices lie anywhere near their places.
Plane random_plane(std::mt19937& random) {
  const auto unit = [&] { return random() / 4294967296.0; };
  const auto columns = 2 + static_cast<std::uint32_t>(random() % 8);
  const auto rows = 2 + static_cast<std::uint32_t>(random() % 8);
  TriangleSoup soup = shapes::plane(columns, rows);
  const double size = unit() < 0.3 ? 0 : 0.4;
  for (std::uint32_t j = 1; j + 1 < rows; ++j) {
    for (std::uint32_t i = 1; i + 1 < columns; ++i) {
      Vec3& p = soup.positions[j * columns + i];
      p = p + Vec3{size * (unit() - 0.5), size * (unit() - 0.5), 0};
    }
  }
  return {Surface(soup), columns - 1.0, rows - 1.0};
}

std::vector<Source> random_sites(const Surface& surface, std::size_t count, std::mt19937& random) {
  const auto unit = [&] { return 0.01 + random() / 4294967296.0; };
  std::vector<Source> sites;
  for (std::size_t i = 0; i < count; ++i) {
    const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    sites.push_back({point_on_face(surface.adjacency(), f, {unit(), unit(), unit()}), 0});
  }
  return sites;
}

std::vector<Vec2> places_of(const Surface& surface, const std::vector<Source>& sites) {
  std::vector<Vec2> places;
  for (const Source& site : sites) {
    const Vec3 p = position_of(surface.mesh(), site.point);
    places.push_back({p.x, p.y});
  }
  return places;
}

Voronoi cells_of(const Surface& surface, const std::vector<Source>& sites, Method method) {
  SolveScratch scratch;
  FieldLimits limits;
  limits.keep_details = false;
  const Field field = surface.field_by(method, sites, limits);
  auto found = voronoi(method, {}, surface.adjacency(), field, 1'000'000, scratch, Cancel());
  REQUIRE(found);
  return std::move(*found);
}

double between(const Voronoi& found, std::uint32_t a, std::uint32_t b) {
  for (const NeighbourCells& pair : found.neighbours) {
    if (pair.sites[0] == a && pair.sites[1] == b) return pair.length;
  }
  return 0;
}

}  // namespace

TEST_CASE("CellsInThePlaneAreThoseOfHalfPlanes") {
  std::mt19937 random(test_seed());
  std::size_t meetings = 0;
  for (int round = 0; round < 60; ++round) {
    const Plane plane = random_plane(random);
    const std::size_t count = 1 + random() % 24;
    CAPTURE(round);
    CAPTURE(count);
    const std::vector<Source> sites = random_sites(plane.surface, count, random);
    const std::vector<Vec2> places = places_of(plane.surface, sites);
    const Method method = random() % 2 == 0 ? Method::exact : Method::chen_han;
    const Voronoi found = cells_of(plane.surface, sites, method);
    const std::vector<Cell> expected = planar_cells(plane.width, plane.height, places);
    REQUIRE(found.cells.size() == count);
    const double tolerance = 1e-9 * plane.width * plane.height;
    // Short lines at sharp angles are right to fewer digits, and may be missing.
    const double line_tolerance = 1e-6;
    std::size_t inner_corners = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      CAPTURE(i);
      const VoronoiCell& cell = found.cells[i];
      CHECK(std::abs(cell.area - expected[i].area()) < tolerance);
      const Vec2 middle = expected[i].centroid();
      const Vec3 centroid = position_of(plane.surface.mesh(), cell.centroid);
      const double rounding = 1e-9 / expected[i].area();
      CHECK(std::abs(cell.mean.x - middle.x) < rounding);
      CHECK(std::abs(cell.mean.y - middle.y) < rounding);
      CHECK(distance(cell.mean, centroid) < rounding);
      CHECK(std::abs(cell.boundary - expected[i].length_against(-1)) < line_tolerance);
      double perimeter = 0;
      for (std::uint32_t j = 0; j < count; ++j) {
        const double length = expected[i].length_against(static_cast<int>(j));
        perimeter += length;
        if (i < j) CHECK(std::abs(between(found, i, j) - length) < line_tolerance);
      }
      CHECK(std::abs(cell.perimeter - perimeter) < line_tolerance);
      const auto& sides = expected[i].sides;
      for (std::size_t k = 0; k < sides.size(); ++k) {
        inner_corners += sides[k] >= 0 && sides[(k + 1) % sides.size()] >= 0 ? 1 : 0;
      }
    }
    CHECK(3 * found.bisectors.vertices.size() == inner_corners);
    for (const VoronoiVertex& vertex : found.bisectors.vertices) {
      const Vec2 at{vertex.position.x, vertex.position.y};
      for (const std::uint32_t site : vertex.sites) {
        CHECK(std::abs(norm(at - places[site]) - vertex.distance) < line_tolerance);
      }
      for (const Vec2 place : places) CHECK(norm(at - place) > vertex.distance - line_tolerance);
      // Round the point as seen from above.
      const Vec2 a = places[vertex.sites[0]];
      CHECK(cross(places[vertex.sites[1]] - a, places[vertex.sites[2]] - a) > -line_tolerance);
      ++meetings;
    }
    for (const Bisector& line : found.bisectors.lines) {
      CHECK(line.sites[0] < line.sites[1]);
      REQUIRE(line.points.size() >= 2);
      for (const Vec3 point : line.points) {
        const Vec2 at{point.x, point.y};
        CHECK(std::abs(norm(at - places[line.sites[0]]) - norm(at - places[line.sites[1]])) <
              line_tolerance);
      }
    }
  }
  CHECK(meetings > 100);
}

// Each straight bisector is one line: its pieces in the faces are put together.
TEST_CASE("BisectorsInThePlaneAreWhole") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 40; ++round) {
    const Plane plane = random_plane(random);
    const std::vector<Source> sites = random_sites(plane.surface, 2 + random() % 12, random);
    const Voronoi found = cells_of(plane.surface, sites, Method::exact);
    for (const NeighbourCells& pair : found.neighbours) {
      std::size_t lines = 0;
      for (const Bisector& line : found.bisectors.lines) {
        if (line.sites != pair.sites) continue;
        ++lines;
        CHECK_FALSE(line.closed);
        CHECK(distance(line.points.front(), line.points.back()) ==
              doctest::Approx(line.length).epsilon(1e-7));
      }
      CHECK(lines == 1);
    }
  }
}

TEST_CASE("OneRoundOfLloydInThePlaneMovesSitesToTheMiddle") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 20; ++round) {
    const Plane plane = random_plane(random);
    const std::vector<Source> sites = random_sites(plane.surface, 2 + random() % 10, random);
    const std::vector<Cell> expected =
        planar_cells(plane.width, plane.height, places_of(plane.surface, sites));
    SolveScratch scratch;
    const auto moved =
        relax_sites(Method::exact, {}, plane.surface.adjacency(), sites, 1, scratch, Cancel());
    REQUIRE(moved);
    const std::vector<Vec2> places = places_of(plane.surface, *moved);
    for (std::size_t i = 0; i < sites.size(); ++i) {
      CHECK(norm(places[i] - expected[i].centroid()) < 1e-9 / expected[i].area());
    }
  }
}

// Four cells meet in each inner corner of a checkerboard: two triangles, whichever.
TEST_CASE("CellsThatMeetFourAtATimeMakeTwoTriangles") {
  for (const std::uint32_t side : {2U, 3U, 5U}) {
    for (const double shift : {0.0, 0.25, 0.5}) {
      for (const Method method : {Method::exact, Method::back_traced}) {
        // Sites in the middle of squares whose corners are vertices, edges' middles or in faces.
        const Surface surface(shapes::plane(2 * side + 1, 2 * side + 1));
        std::vector<Source> sites;
        for (std::uint32_t j = 0; j < side; ++j) {
          for (std::uint32_t i = 0; i < side; ++i) {
            const double x = 2 * i + 1 + shift;
            const double y = 2 * j + 1 + shift / 2;
            const auto& mesh = surface.mesh();
            for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
              const auto& t = mesh.faces()[f];
              const Vec3 a = mesh.positions()[t[0]];
              const Vec3 b = mesh.positions()[t[1]] - a;
              const Vec3 c = mesh.positions()[t[2]] - a;
              const double area2 = b.x * c.y - b.y * c.x;
              const double v = ((x - a.x) * c.y - (y - a.y) * c.x) / area2;
              const double w = (b.x * (y - a.y) - b.y * (x - a.x)) / area2;
              if (v < 0 || w < 0 || v + w > 1) continue;
              sites.push_back({point_on_face(surface.adjacency(), f, {1 - v - w, v, w}), 0});
              break;
            }
          }
        }
        CAPTURE(side);
        CAPTURE(shift);
        REQUIRE(sites.size() == std::size_t{side} * side);
        const Voronoi found = cells_of(surface, sites, method);
        CHECK(found.bisectors.vertices.size() == std::size_t{2} * (side - 1) * (side - 1));
      }
    }
  }
}
