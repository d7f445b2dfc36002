// Closed paths become closed geodesics: against closed forms on prisms, cubes, waists, tori, balls
// and planes with holes.
#include "core/straighten/tighten_loop.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/core/straighten/loops.h"
#include "tests/fixtures/mixed_scales.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/tube.h"

using namespace geodesic;
using namespace geodesic::loops;
using fixtures::Surface;
using std::numbers::pi;

TEST_CASE("RoundAPrismALoopIsAsLongAsThePolygonHoweverTheCutIsTilted") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < 30; ++round) {
    const auto n = static_cast<std::uint32_t>(3 + random() % 40);
    const auto rows = static_cast<std::uint32_t>(1 + random() % 12);
    const Placed placed(random);
    const Surface surface(placed.place(fixtures::tube(n, 6, rows)));
    const auto face = static_cast<std::uint32_t>((rows / 2) * 2 * n + random() % (2 * n));
    const SurfacePoint at = surface.on(face, {0.3, 0.3, 0.4});
    const double tilt = 0.9 * unit_of(random);
    const double turn = 2 * pi * unit_of(random);
    const Vec3 normal = placed.direction({tilt * std::cos(turn), tilt * std::sin(turn), 1});
    const auto start = section_of(surface, at, normal);
    if (!start) continue;  // it meets an open end
    const TightLoop loop = tight(surface, *start);
    CHECK(loop.path.length == doctest::Approx(placed.scale * polygon(n, 1)).epsilon(1e-12));
    check_is_geodesic(surface, loop.path);
  }
}

// Rows of vertices about an axis: the narrowest is where a loop ends, wherever it began.
TEST_CASE("ALoopSlipsToTheWaist") {
  std::mt19937 random(fixtures::test_seed() + 1);
  for (int round = 0; round < 20; ++round) {
    const int n = static_cast<int>(6 + random() % 30);
    const int rows = static_cast<int>(7 + random() % 20);
    const int waist = static_cast<int>(2 + random() % (rows - 4));
    const double least = 0.3 + unit_of(random);
    std::vector<std::pair<double, double>> profile;
    for (int i = 0; i < rows; ++i) {
      const double off = i - waist;
      profile.emplace_back(least + 0.02 * off * off + 0.01 * std::abs(off), 0.4 * i);
    }
    const Placed placed(random);
    const Surface surface(placed.place(fixtures::rings(n, profile)));
    const int row = static_cast<int>(1 + random() % (rows - 3));
    const auto face = static_cast<std::uint32_t>(row * 2 * n + random() % (2 * n));
    const double tilt = 0.2 * unit_of(random);
    const auto start =
        section_of(surface, surface.on(face, {0.2, 0.3, 0.5}), placed.direction({tilt, 0, 1}));
    if (!start) continue;
    const TightLoop loop = tight(surface, *start);
    CHECK(loop.path.length ==
          doctest::Approx(placed.scale * polygon(static_cast<std::uint32_t>(n), least))
              .epsilon(1e-9));
    check_is_geodesic(surface, loop.path);
  }
}

// A truncated cone has its waist at the boundary.
TEST_CASE("ALoopSlipsToANarrowEnd") {
  std::mt19937 random(fixtures::test_seed() + 2);
  for (int round = 0; round < 10; ++round) {
    const int n = static_cast<int>(5 + random() % 30);
    const double slope = 0.05 + unit_of(random);
    std::vector<std::pair<double, double>> profile;
    for (int i = 0; i < 9; ++i) profile.emplace_back(1 + slope * i, i);
    const Placed placed(random);
    const Surface surface(placed.place(fixtures::rings(n, profile)));
    const auto start =
        section_of(surface, surface.on(static_cast<std::uint32_t>(8 * n), {0.2, 0.3, 0.5}),
                   placed.direction({0.05, 0, 1}));
    REQUIRE(start);
    const TightLoop loop = tight(surface, *start);
    CHECK(loop.path.length ==
          doctest::Approx(placed.scale * polygon(static_cast<std::uint32_t>(n), 1)).epsilon(1e-9));
  }
}

// A capsule: a cylinder between two half balls. A loop on the cylinder stays there, however it
// began.
TEST_CASE("OnACapsuleALoopStaysOnTheCylinder") {
  std::mt19937 random(fixtures::test_seed() + 3);
  for (int round = 0; round < 10; ++round) {
    const int n = static_cast<int>(8 + random() % 20);
    std::vector<std::pair<double, double>> profile;
    for (int i = 1; i <= 6; ++i)
      profile.emplace_back(std::sin(pi * i / 12), -std::cos(pi * i / 12));
    for (int i = 1; i <= 8; ++i) profile.emplace_back(1, 0.5 * i);
    for (int i = 5; i >= 1; --i) {
      profile.emplace_back(std::sin(pi * i / 12), 4 + std::cos(pi * i / 12));
    }
    TriangleSoup soup = fixtures::rings(n, profile);
    const auto last = static_cast<std::uint32_t>(soup.positions.size());
    soup.positions.push_back({0, 0, -1});
    soup.positions.push_back({0, 0, 5});
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(n); ++i) {
      const std::uint32_t j = (i + 1) % static_cast<std::uint32_t>(n);
      soup.faces.push_back({i, j, last});
      soup.faces.push_back({last - static_cast<std::uint32_t>(n) + i,
                            last - static_cast<std::uint32_t>(n) + j, last + 1});
    }
    const Placed placed(random);
    const Surface surface(placed.place(soup));
    const double full = placed.scale * polygon(static_cast<std::uint32_t>(n), 1);
    const auto on_row = [&](int row, double tilt) {
      const auto start =
          section_of(surface, surface.on(static_cast<std::uint32_t>(row * 2 * n), {0.2, 0.3, 0.5}),
                     placed.direction({tilt, 0, 1}));
      REQUIRE(start);
      return tighten_loop(surface.adjacency(), *start, Cancel());
    };
    const auto on_cylinder = on_row(9, 0.5 * unit_of(random));
    REQUIRE(on_cylinder);
    CHECK(on_cylinder->path.length == doctest::Approx(full).epsilon(1e-12));
    check_is_geodesic(surface, on_cylinder->path);
    // Nothing holds it on the ball.
    const auto on_ball = on_row(1, 0);
    REQUIRE_FALSE(on_ball);
    CHECK(on_ball.error().code == ErrorCode::no_loop);
    CHECK(on_ball.error().detail ==
          "the loop contracts to a point: it goes round nothing that holds it");
  }
}

namespace {

// The surface of the unit cube in n x n squares a side, by welding the sides together.
TriangleSoup cube(int n) {
  TriangleSoup soup;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {0.0, 1.0}) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const auto first = static_cast<std::uint32_t>(soup.positions.size());
          for (const auto& [u, v] : {std::pair{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}) {
            const double a = static_cast<double>(u) / n;
            const double b = static_cast<double>(v) / n;
            soup.positions.push_back(axis == 0   ? Vec3{side, a, b}
                                     : axis == 1 ? Vec3{b, side, a}
                                                 : Vec3{a, b, side});
          }
          soup.faces.push_back({first, first + 1, first + 2});
          soup.faces.push_back({first, first + 2, first + 3});
        }
      }
    }
  }
  return soup;
}

}  // namespace

TEST_CASE("RoundFourSidesOfACubeAndRoundAllSix") {
  std::mt19937 random(fixtures::test_seed() + 4);
  for (int round = 0; round < 12; ++round) {
    const int n = static_cast<int>(1 + random() % 6);
    const Surface surface(cube(n));
    // On the side x = 0, which has the first faces.
    const std::uint32_t face = random() % static_cast<std::uint32_t>(2 * n * n);
    const SurfacePoint at = surface.on(face, {0.31, 0.33, 0.36});
    const double tilt = 0.1 * unit_of(random);
    if (const auto start = section_of(surface, at, {tilt / 7, tilt, 1})) {
      const auto loop = tighten_loop(surface.adjacency(), *start, Cancel());
      // Where the cut is over an edge of the cube, it may be drawn off a corner.
      if (loop) {
        check_tight(surface, *start, *loop);
        check_is_geodesic(surface, loop->path);
        // Of the family of parallels, whichever it comes to.
        CHECK(loop->path.length == doctest::Approx(4).epsilon(1e-9));
      } else {
        CHECK(loop.error().code == ErrorCode::no_loop);
      }
    }
    // Straight across: of the family of parallels it is one already.
    const auto flat = section_of(surface, at, {0, 0, 1});
    REQUIRE(flat);
    CHECK(tight(surface, *flat).path.length == doctest::Approx(4).epsilon(1e-12));
    // The planes at a right angle to the diagonal cut all six sides where they are between the two
    // triangles of corners; in the middle in a regular hexagon, and the others are parallel to it.
    for (std::uint32_t f = 0; f < static_cast<std::uint32_t>(2 * n * n); ++f) {
      const SurfacePoint middle = surface.on(f, {0.33, 0.33, 0.34});
      const Vec3 p = position_of(surface.mesh(), middle);
      if (p.x + p.y + p.z < 1.02 || p.x + p.y + p.z > 1.98) continue;
      const auto hexagon = section_of(surface, middle, {1, 1, 1});
      REQUIRE(hexagon);
      const TightLoop loop = tight(surface, *hexagon);
      CHECK(loop.path.length == doctest::Approx(3 * std::sqrt(2.0)).epsilon(1e-12));
      check_is_geodesic(surface, loop.path);
    }
  }
}

TEST_CASE("RoundATorusTheLoopIsNoLongerThanTheMeshsOwnCircles") {
  std::mt19937 random(fixtures::test_seed() + 5);
  for (int round = 0; round < 8; ++round) {
    const int n = static_cast<int>(8 + random() % 16);     // round the axis
    const int tube = static_cast<int>(5 + random() % 10);  // round the tube
    const double thick = 0.2 + 0.4 * unit_of(random);
    std::vector<std::pair<double, double>> profile;
    for (int i = 0; i < tube; ++i) {
      // The innermost row is one of vertices.
      const double angle = pi + 2 * pi * i / tube;
      profile.emplace_back(1 + thick * std::cos(angle), thick * std::sin(angle));
    }
    profile.push_back(profile.front());  // welded, it closes
    const Placed placed(random);
    const Surface surface(placed.place(fixtures::rings(n, profile)));
    // Along the rows, it slips to the inner circle.
    std::vector<std::uint32_t> along;
    // Of the inner half, for on the outer one a band of faces along the axis may hold it.
    const int row = std::array{0, 1, tube - 1}[random() % 3];
    for (int i = 0; i < n; ++i) along.push_back(static_cast<std::uint32_t>(row * n + i));
    const auto round_axis = round_by(surface, along);
    REQUIRE(round_axis);
    const TightLoop inner = tight(surface, *round_axis);
    const double circle = placed.scale * polygon(static_cast<std::uint32_t>(n), 1 - thick);
    CHECK(inner.path.length <= circle * (1 + 1e-12));
    check_is_geodesic(surface, inner.path);
    // Round the tube: the columns of vertices are polygons.
    std::vector<std::uint32_t> across;
    for (int i = 0; i < tube; ++i) across.push_back(static_cast<std::uint32_t>(i * n));
    const auto round_tube = round_by(surface, across);
    REQUIRE(round_tube);
    const TightLoop meridian = tight(surface, *round_tube);
    const double most = placed.scale * polygon(static_cast<std::uint32_t>(tube), thick);
    CHECK(meridian.path.length <= most * (1 + 1e-12));
    CHECK(meridian.path.length >= 0.5 * most);
    check_is_geodesic(surface, meridian.path);
  }
}

TEST_CASE("OnABallEveryLoopContracts") {
  std::mt19937 random(fixtures::test_seed() + 6);
  int contracted = 0;
  for (int round = 0; round < 10; ++round) {
    const Surface surface(Placed(random).place(shapes::icosphere(1 + random() % 3)));
    const auto face = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    const SurfacePoint at = surface.on(face, {0.2, 0.3, 0.5});
    const auto start = section_of(surface, at, any_direction(random));
    if (!start) continue;
    const auto loop = tighten_loop(surface.adjacency(), *start, Cancel());
    if (!loop) {
      CHECK(loop.error().code == ErrorCode::no_loop);
      ++contracted;
    } else {  // a polyhedron may have closed geodesics that no corner is in the way of
      check_is_geodesic(surface, loop->path);
    }
  }
  CHECK(contracted > 0);
}

namespace {

// The length of the convex hull of points in the plane z = 0, edge by edge: from a corner to
// another, with nothing to the right of the line, and nothing beyond on it.
double hull_of(const std::vector<Vec3>& points) {
  double length = 0;
  for (const Vec3& a : points) {
    for (const Vec3& b : points) {
      if (a == b) continue;
      bool is_edge = true;
      for (const Vec3& p : points) {
        const double side = cross(b - a, p - a).z;
        const double along = dot(b - a, p - a);
        if (side < 0 || (side == 0 && (along < 0 || along > dot(b - a, b - a)))) is_edge = false;
      }
      if (is_edge) length += distance(a, b);
    }
  }
  return length;
}

}  // namespace

TEST_CASE("ABandRoundTheHolesOfAPlaneIsTheirConvexHull") {
  std::mt19937 random(fixtures::test_seed() + 10);
  for (int round = 0; round < 10; ++round) {
    std::vector<shapes::Hole> holes;
    std::vector<Vec3> corners;
    const auto count = 1 + random() % 3;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
      const std::uint32_t size = 1 + below(6);
      const shapes::Hole hole{2 + below(26 - size), 2 + below(26 - size), size};
      holes.push_back(hole);
      for (const std::uint32_t x : {hole.first_column, hole.first_column + size}) {
        for (const std::uint32_t y : {hole.first_row, hole.first_row + size}) {
          const Vec3 corner{double(x), double(y), 0};
          if (std::find(corners.begin(), corners.end(), corner) == corners.end()) {
            corners.push_back(corner);
          }
        }
      }
    }
    const Surface surface(shapes::plane_with_holes(30, 30, holes));
    const auto start = round_by(surface, {0, 29, 899, 870});
    REQUIRE(start);
    CHECK(start->length == doctest::Approx(4 * 29));
    const TightLoop loop = tight(surface, *start);
    CHECK(loop.path.length == doctest::Approx(hull_of(corners)).epsilon(1e-12));
    check_is_geodesic(surface, loop.path);
  }
}
