// Surfaces on which a path has no vertex to cross, or more places than two, or nothing to
// tell them by.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/straighten/shorten_path.h"
#include "tests/fixtures/faces_thrown_together.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/shortened.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::along_edges;
using fixtures::path_by;
using fixtures::same_points;
using fixtures::shortened;
using fixtures::Surface;

TEST_CASE("FlippedFacesChangeNothing") {
  TriangleSoup soup = shapes::terrain(30, 5, 8);
  const auto lengths = [](const TriangleSoup& mesh) {
    const Surface surface(mesh);
    std::vector<double> result;
    for (const std::uint32_t target : {29U, 450U, 899U}) {
      result.push_back(
          shortened(surface, path_by(surface, Method::dijkstra, surface.at(3), surface.at(target)))
              .length);
    }
    return result;
  };
  const auto before = lengths(soup);
  for (std::size_t f = 0; f < soup.faces.size(); f += 3) {
    std::swap(soup.faces[f][1], soup.faces[f][2]);
  }
  const auto after = lengths(soup);
  for (std::size_t i = 0; i < before.size(); ++i) {
    CHECK(after[i] == doctest::Approx(before[i]).epsilon(1e-12));
  }
}

TEST_CASE("ThePagesOfABookAreTurnedWherePathsMeetTheSpine") {
  // Pages of 5 x 5 vertices on the spine x = 0, z = 0; vertex (i, j) of page p is
  // number 25 p + 5 j + i.
  TriangleSoup book;
  const std::vector<Vec3> out{{1, 0, 0}, {-1, 0, 0}, {0, 0, 1}};
  for (const Vec3 page : out) {
    const auto first = static_cast<std::uint32_t>(book.positions.size());
    for (int j = 0; j < 5; ++j) {
      for (int i = 0; i < 5; ++i)
        book.positions.push_back(double(i) * page + Vec3{0, double(j), 0});
    }
    for (auto t : shapes::plane(5, 5).faces) {
      book.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  const Surface surface(book);
  REQUIRE(surface.adjacency().report().edges_non_manifold == 4);
  // From (4, 0) on the first page to (4, 4) on the third: down to the spine, along
  // it, and out; or by a walk on the second page first.
  const Path along_spine = along_edges(surface, {4, 3, 2, 1, 0, 5, 10, 15, 20, 71, 72, 73, 74});
  CHECK(std::abs(shortened(surface, along_spine).length - std::hypot(8, 4)) <= 1e-12);
  const Path by_second =
      along_edges(surface, {4, 3, 2, 1, 0, 26, 27, 32, 37, 36, 10, 15, 20, 71, 72, 73, 74});
  CHECK(std::abs(shortened(surface, by_second).length - std::hypot(8, 4)) <= 1e-12);
}

TEST_CASE("APinchedVertexHoldsThePath") {
  // Two squares of 3 x 3 vertices that meet in one corner.
  TriangleSoup soup = shapes::plane(3, 3);
  for (const Vec3 p : shapes::plane(3, 3).positions) soup.positions.push_back(p + Vec3{2, 2, 0});
  for (const auto& t : shapes::plane(3, 3).faces) {
    soup.faces.push_back({t[0] + 9, t[1] + 9, t[2] + 9});
  }
  const Surface surface(soup);
  REQUIRE(surface.adjacency().report().vertices_pinched == 1);
  // From (0, 2) to (4, 3): by the corner (2, 2) whatever the way.
  const Path path =
      shortened(surface, path_by(surface, Method::dijkstra, surface.at(6), surface.at(9 + 5)));
  CHECK(std::abs(path.length - (2 + std::hypot(2, 1))) <= 1e-12);
  bool at_corner = false;
  for (const PathPoint& p : path.points) at_corner |= p.position == Vec3{2, 2, 0};
  CHECK(at_corner);
}

TEST_CASE("FacesWithoutAreaAreCrossedLikeOthers") {
  // Two squares; along the seam the left one has one edge and the right one two, with a
  // face without area between them.
  const Surface surface(
      TriangleSoup{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0.5, 0}, {2, 0, 0}, {2, 1, 0}},
                   {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}, {1, 5, 4}, {4, 5, 6}, {4, 6, 2}}});
  const Path up = shortened(surface, along_edges(surface, {0, 1, 4, 6}));
  CHECK(std::abs(up.length - std::hypot(2, 1)) <= 1e-12);
  const Path across = shortened(surface, along_edges(surface, {3, 2, 4, 5}));
  CHECK(std::abs(across.length - std::hypot(2, 1)) <= 1e-12);
}

// Two faces of one line, with a long side in common: a path to its end and back goes straight.
TEST_CASE("PathsInFacesWithoutWidthDoNotTurnBack") {
  fixtures::RandomMesh random(fixtures::test_seed());
  for (int i = 0; i < 200; ++i) {
    CAPTURE(i);
    const Vec3 along{random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5};
    const double from = 0.01 + 0.98 * random.unit();
    const double to = 0.01 + 0.98 * random.unit();
    if (std::abs(from - to) < 1e-3) continue;
    const Surface surface(
        TriangleSoup{{{0, 0, 0}, from * along, along, to * along}, {{0, 1, 2}, {0, 3, 2}}});
    for (const std::uint32_t end : {0U, 2U}) {
      const Path path = shortened(surface, along_edges(surface, {1, end, 3}));
      CHECK(path.length == doctest::Approx(std::abs(from - to) * norm(along)).epsilon(1e-9));
    }
  }
}

TEST_CASE("NeedlesAndTheirLikeComeToAnEnd") {
  for (const double thin : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-30}) {
    CAPTURE(thin);
    // A plane whose columns are as thin as that, one by one, in turn.
    TriangleSoup soup = shapes::plane(12, 12);
    for (Vec3& p : soup.positions) {
      const int column = static_cast<int>(p.x);
      p.x = column / 2 + (column % 2) * thin;
    }
    const Surface surface(soup);
    for (const std::uint32_t target : {11U, 77U, 143U}) {
      const Path path =
          shortened(surface, path_by(surface, Method::dijkstra, surface.at(0), surface.at(target)));
      CHECK(path.length == doctest::Approx(norm(soup.positions[target])).epsilon(1e-9));
    }
  }
}

TEST_CASE("VerticesNextToNothingApartDoNotHoldThePath") {
  // A terrain whose columns are there twice, the second a hair further on: a path over
  // both of a pair gains nothing that can be seen by passing the first on its other side.
  const TriangleSoup terrain = shapes::terrain(24, 6, 3);
  const auto total_length = [&](double hair) {
    TriangleSoup soup = shapes::plane(47, 24);
    for (std::uint32_t j = 0; j < 24; ++j) {
      for (std::uint32_t i = 0; i < 47; ++i) {
        const Vec3 here = terrain.positions[j * 24 + i / 2];
        const Vec3 next = terrain.positions[j * 24 + (i + 1) / 2];
        soup.positions[j * 47 + i] = here + (i % 2) * hair * (next - here);
      }
    }
    const Surface surface(soup);
    const Field field = surface.field_by(Method::dijkstra, {Source{surface.at(500), 0}});
    double sum = 0;
    for (std::uint32_t target = 7; target < soup.positions.size(); target += 97) {
      const auto path = surface.path(field, surface.at(target));
      REQUIRE(path);
      const auto shorter = shorten_path(surface.adjacency(), *path, Cancel());
      REQUIRE(shorter.has_value());
      sum += shorter->length;
    }
    return sum;
  };
  const double expected = total_length(1e-6);
  for (const double hair : {1e-8, 1e-10, 1e-12}) {
    CHECK(total_length(hair) == doctest::Approx(expected).epsilon(1e-6));
  }
}

TEST_CASE("HugeAndTinyMeshesShortenAlike") {
  const TriangleSoup unit = shapes::terrain(16, 3, 1);
  const auto length = [](const TriangleSoup& soup) {
    const Surface surface(soup);
    const Path path = path_by(surface, Method::dijkstra, surface.at(0), surface.at(250));
    const auto shorter = shorten_path(surface.adjacency(), path, Cancel());
    REQUIRE(shorter.has_value());
    return shorter->length;
  };
  const double expected = length(unit);
  for (const double scale : {0x1p-130, 0x1p130}) {
    TriangleSoup soup = unit;
    for (Vec3& p : soup.positions) p = scale * p;
    CHECK(length(soup) == doctest::Approx(scale * expected).epsilon(1e-12));
  }
}

TEST_CASE("FacesThrownTogetherAtRandomAreNoTrap") {
  std::mt19937 random(11);
  int compared = 0;
  for (int round = 0; round < 150; ++round) {
    const Surface surface(fixtures::faces_thrown_together(random, 22));
    for (const Method method : {Method::dijkstra, Method::wavefront}) {
      const std::uint32_t from = random() % 12U;
      if (surface.at(from).face == kNone) continue;
      const Field field = surface.field_by(method, {Source{surface.at(from), 0}});
      for (std::uint32_t target = 0; target < 12; ++target) {
        if (surface.at(target).face == kNone) continue;
        const auto path = surface.path(field, surface.at(target));
        if (!path) continue;
        ++compared;
        ShortenCounts counts;
        const Path shorter = shortened(surface, *path, &counts);
        CHECK(counts.locally_shortest);
        CHECK(shorter.length >=
              distance(path->points.front().position, path->points.back().position) * (1 - 1e-12));
      }
    }
  }
  CHECK(compared > 1000);
}

TEST_CASE("SegmentsThatDoNotMeetAreLeftAlone") {
  const Surface surface(shapes::plane(5, 5));
  Path broken = along_edges(surface, {0, 1, 2, 7});
  broken.points[1].point = surface.on(20, {0.3, 0.3, 0.4});
  const auto result = shorten_path(surface.adjacency(), broken, Cancel());
  REQUIRE(result.has_value());
  CHECK(same_points(*result, broken));
}
