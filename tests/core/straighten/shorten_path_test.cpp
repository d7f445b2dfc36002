#include "core/straighten/shorten_path.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/paths/join_paths.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/shortened.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::along_edges;
using fixtures::check_is_a_path;
using fixtures::check_is_locally_shortest;
using fixtures::off_the_line;
using fixtures::path_by;
using fixtures::same_points;
using fixtures::shortened;
using fixtures::Surface;
using std::numbers::pi;

namespace {

// The surface of the unit cube, each side a grid of n x n squares; and the number of
// the vertex at a place.
struct Cube {
  TriangleSoup soup;
  std::map<std::array<int, 3>, std::uint32_t> number;
  int n;

  explicit Cube(int squares) : n(squares) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {0, n}) {
        for (int i = 0; i < n; ++i) {
          for (int j = 0; j < n; ++j) {
            const auto at = [&](int u, int v) {
              std::array<int, 3> p{};
              p[static_cast<std::size_t>(axis)] = side;
              p[static_cast<std::size_t>((axis + 1) % 3)] = u;
              p[static_cast<std::size_t>((axis + 2) % 3)] = v;
              return vertex(p);
            };
            soup.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            soup.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
          }
        }
      }
    }
  }
  std::uint32_t vertex(std::array<int, 3> p) {
    const auto [it, fresh] =
        number.try_emplace(p, static_cast<std::uint32_t>(soup.positions.size()));
    if (fresh) soup.positions.push_back({p[0] / double(n), p[1] / double(n), p[2] / double(n)});
    return it->second;
  }
};

}  // namespace

TEST_CASE("APathAlongEdgesOfAPlaneBecomesTheStraightLine") {
  for (const TriangleSoup& soup :
       {shapes::plane(30, 30), shapes::plane(30, 30, shapes::Diagonal::falling),
        shapes::terrain(30, 0, 1), shapes::shuffled(shapes::terrain(30, 0, 2), 3)}) {
    const Surface surface(soup);
    const Field field = surface.field_by(Method::dijkstra, {Source{surface.at(5), 0}});
    for (const std::uint32_t target : {6U, 29U, 31U, 500U, 617U, 899U}) {
      const auto path = surface.path(field, surface.at(target));
      REQUIRE(path);
      const Path straight = shortened(surface, *path);
      const Vec3 a = soup.positions[5];
      const Vec3 b = soup.positions[target];
      CHECK(std::abs(straight.length - distance(a, b)) <= 1e-12);
      CHECK(off_the_line(straight, a, b) <= 1e-12);
      check_is_locally_shortest(surface, straight);
    }
  }
}

TEST_CASE("EndsInsideFacesAndOnEdgesStayWhereTheyAre") {
  const Surface surface(shapes::terrain(20, 0, 4));
  for (const auto& bary : {std::array<double, 3>{0.2, 0.3, 0.5}, {0, 0.25, 0.75}, {0.5, 0.5, 0}}) {
    const SurfacePoint from = surface.on(10, bary);
    const SurfacePoint to = surface.on(700, {bary[2], bary[0], bary[1]});
    for (const Method method : {Method::wavefront, Method::dijkstra}) {
      const Path straight = shortened(surface, path_by(surface, method, from, to));
      const Vec3 a = position_of(surface.mesh(), from);
      const Vec3 b = position_of(surface.mesh(), to);
      CHECK(distance(straight.points.front().position, a) <= 1e-14);
      CHECK(std::abs(straight.length - distance(a, b)) <= 1e-12);
    }
  }
}

TEST_CASE("APathWithinOneFaceIsStraightAsItIs") {
  const Surface surface(shapes::plane(5, 5));
  const Path path = path_by(surface, Method::wavefront, surface.on(7, {0.2, 0.3, 0.5}),
                            surface.on(7, {0.5, 0.4, 0.1}));
  CHECK(same_points(shortened(surface, path), path));
  const Path point = path_by(surface, Method::wavefront, surface.at(3), surface.at(3));
  CHECK(shortened(surface, point).points.size() == 1);
}

TEST_CASE("AroundASquareHoleItIsShortestOnTheSideItWasOn") {
  // From (0, 10) to (24, 10) with the hole [8, 14] x [8, 18] in the way.
  const std::vector<shapes::Hole> holes{{8, 8, 6}, {8, 12, 6}};
  const Surface surface(shapes::plane_with_holes(25, 25, holes));
  const auto vertex = [&](std::uint32_t x, std::uint32_t y) { return surface.at(25 * y + x); };
  const auto by_way_of = [&](const SurfacePoint& via) {
    const std::vector<Path> legs{path_by(surface, Method::dijkstra, vertex(0, 10), via),
                                 path_by(surface, Method::dijkstra, via, vertex(24, 10))};
    return join_paths(legs);
  };
  const Path below = shortened(surface, by_way_of(vertex(11, 0)));
  CHECK(std::abs(below.length - (std::hypot(8, 2) + 6 + std::hypot(10, 2))) <= 1e-12);
  check_is_locally_shortest(surface, below);
  const Path above = shortened(surface, by_way_of(vertex(11, 24)));
  CHECK(std::abs(above.length - (std::hypot(8, 8) + 6 + std::hypot(10, 8))) <= 1e-12);
  check_is_locally_shortest(surface, above);
}

TEST_CASE("OnACubePathsUnfoldOverTheEdge") {
  Cube cube(10);
  const std::uint32_t top = cube.vertex({3, 6, 10});
  const std::uint32_t front = cube.vertex({6, 10, 7});
  const Surface surface(cube.soup);
  const Path path =
      shortened(surface, path_by(surface, Method::dijkstra, surface.at(top), surface.at(front)));
  // Over the edge y = 1, z = 1: 0.4 on the top and 0.3 down the front.
  CHECK(std::abs(path.length - std::hypot(0.3, 0.7)) <= 1e-12);
  check_is_locally_shortest(surface, path);
}

TEST_CASE("ACornerOfACubeIsSlippedOver") {
  // From the middle of the top along its diagonal to a corner, and down the edge.
  Cube cube(4);
  std::vector<std::uint32_t> by_corner;
  for (int i = 2; i <= 4; ++i) by_corner.push_back(cube.vertex({i, i, 4}));
  for (int i = 3; i >= 2; --i) by_corner.push_back(cube.vertex({4, 4, i}));
  const Surface surface(cube.soup);
  const Path path = shortened(surface, along_edges(surface, by_corner));
  CHECK(std::abs(path.length - std::hypot(0.5, 1)) <= 1e-12);
  check_is_locally_shortest(surface, path);
}

TEST_CASE("OnACylinderItIsAHelix") {
  constexpr std::uint32_t kAround = 16;
  constexpr std::uint32_t kRows = 9;
  TriangleSoup tube;
  for (std::uint32_t j = 0; j < kRows; ++j) {
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double u = 2 * pi * i / kAround;
      tube.positions.push_back({std::cos(u), std::sin(u), 0.5 * j});
    }
  }
  const auto vertex = [](std::uint32_t i, std::uint32_t j) { return j * kAround + i % kAround; };
  for (std::uint32_t j = 0; j + 1 < kRows; ++j) {
    for (std::uint32_t i = 0; i < kAround; ++i) {
      tube.faces.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      tube.faces.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  }
  const Surface surface(tube);
  // Up the side, round and up again: the path keeps the number of turns it has.
  for (const std::uint32_t steps : {5U, 11U, 37U}) {
    std::vector<std::uint32_t> stairs;
    for (std::uint32_t j = 0; j < 4; ++j) stairs.push_back(vertex(0, j));
    for (std::uint32_t i = 1; i <= steps; ++i) stairs.push_back(vertex(i, 3));
    for (std::uint32_t j = 4; j < kRows; ++j) stairs.push_back(vertex(steps, j));
    const Path path = shortened(surface, along_edges(surface, stairs));
    const double around = steps * 2 * std::sin(pi / kAround);
    CHECK(std::abs(path.length - std::hypot(around, 0.5 * (kRows - 1))) <= 1e-12);
  }
}

TEST_CASE("ASaddleVertexStaysABend") {
  // Eight faces round vertex 0, alternately up and down: the angles add up to more
  // than 2 pi, and half of them lie on either side of the way from 1 to 5.
  TriangleSoup soup{{{0, 0, 0}}, {}};
  for (int i = 0; i < 8; ++i) {
    const double u = pi * i / 4;
    soup.positions.push_back({std::cos(u), std::sin(u), i % 2 == 0 ? 0.5 : -0.5});
  }
  for (std::uint32_t i = 0; i < 8; ++i) soup.faces.push_back({0, i + 1, (i + 1) % 8 + 1});
  const Surface surface(soup);
  const Path through = along_edges(surface, {1, 0, 5});
  CHECK(same_points(shortened(surface, through), through));
  // The way from 1 to 3 has a side of one quarter.
  const Path corner = shortened(surface, along_edges(surface, {1, 0, 3}));
  CHECK(corner.length < 2 * std::hypot(1, 0.5) - 0.1);
}

TEST_CASE("OnASphereItIsCloseToAGreatCircle") {
  const TriangleSoup soup = shapes::icosphere(4);
  const Surface surface(soup);
  const Field field = surface.field_by(Method::dijkstra, {Source{surface.at(0), 0}});
  for (std::uint32_t target = 100; target < soup.positions.size(); target += 401) {
    const auto path = surface.path(field, surface.at(target));
    REQUIRE(path);
    const Path shorter = shortened(surface, *path);
    const double arc = std::acos(dot(soup.positions[0], soup.positions[target]));
    CHECK(shorter.length == doctest::Approx(arc).epsilon(0.003));
    CHECK(off_the_line(shorter, {}, cross(soup.positions[0], soup.positions[target])) > 0.9);
    check_is_locally_shortest(surface, shorter);
  }
}

TEST_CASE("RandomPathsBecomeLocallyShortestAndStaySo") {
  std::mt19937 random(5);
  for (const TriangleSoup& soup :
       {shapes::terrain(40, 3, 4), shapes::terrain(40, 12, 5), shapes::saddle(30, 12),
        shapes::torus_knot(150, 12, 0.4), shapes::icosphere(3),
        shapes::shuffled(shapes::terrain(40, 6, 7), 2)}) {
    const Surface surface(soup);
    for (int pair = 0; pair < 8; ++pair) {
      const auto vertices = static_cast<std::uint32_t>(soup.positions.size());
      const std::uint32_t from = random() % vertices;
      const auto to =
          surface.on(static_cast<std::uint32_t>(random() % soup.faces.size()), {0.2, 0.5, 0.3});
      for (const Method method : {Method::dijkstra, Method::wavefront}) {
        const Path path = path_by(surface, method, surface.at(from), to);
        ShortenCounts counts;
        const Path shorter = shortened(surface, path, &counts);
        CHECK(counts.locally_shortest);
        check_is_locally_shortest(surface, shorter);
        CHECK(same_points(shortened(surface, shorter), shorter));
        if (method == Method::dijkstra) CHECK(shorter.length < path.length);
      }
    }
  }
}

TEST_CASE("WaysOutAndBackUnravel") {
  const Surface surface(shapes::plane(9, 9));
  const Path wandering =
      along_edges(surface, {0, 1, 2, 3, 2, 1, 10, 11, 12, 21, 12, 13, 13 + 9, 13, 4});
  const Path straight = shortened(surface, wandering);
  CHECK(std::abs(straight.length - 4) <= 1e-12);
  // A loop that can be drawn together is drawn together.
  const Path loop = along_edges(surface, {30, 31, 32, 41, 50, 49, 48, 39, 30});
  CHECK(shortened(surface, loop).length <= 1e-12);
}

TEST_CASE("ShorteningStopsWhenCancelled") {
  // Row after row, to and fro.
  const Surface surface(shapes::plane(60, 60));
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < 3600; ++i)
    rows.push_back(i / 60 % 2 == 0 ? i : i / 60 * 60 + 59 - i % 60);
  const Path path = along_edges(surface, rows);
  CHECK(std::abs(shortened(surface, path).length - 59) <= 1e-12);
  const auto result = shorten_path(surface.adjacency(), path, Cancel([] { return true; }));
  REQUIRE_FALSE(result.has_value());
  CHECK(result.error().code == ErrorCode::cancelled);
}

TEST_CASE("JoinedPathsKeepTheirJoints") {
  const Surface surface(shapes::plane(9, 9));
  const std::vector<Path> legs{path_by(surface, Method::wavefront, surface.at(0), surface.at(4)),
                               path_by(surface, Method::wavefront, surface.at(4), surface.at(4)),
                               path_by(surface, Method::wavefront, surface.at(4), surface.at(8)),
                               path_by(surface, Method::wavefront, surface.at(8), surface.at(80))};
  const Path joined = join_paths(legs);
  check_is_a_path(surface.adjacency(), joined, 9);
  CHECK(joined.length == doctest::Approx(16));
  std::size_t at_joint = 0;
  for (const PathPoint& p : joined.points) at_joint += p.position == Vec3{4, 0, 0};
  CHECK(at_joint == 1);
  CHECK(joined.points.size() ==
        legs[0].points.size() + legs[2].points.size() - 1 + legs[3].points.size() - 1);
  CHECK(join_paths({}).points.empty());
}
