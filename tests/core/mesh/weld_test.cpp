#include "core/mesh/weld.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <random>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/shapes.h"
#include "core/surface/adjacency.h"

using namespace geodesic;

namespace {

// The rule as it is said, by comparing with everyone.
std::uint64_t weld_vs_bruteforce(TriangleSoup& soup, double tolerance) {
  std::vector<std::size_t> stayed;
  std::uint64_t moved = 0;
  for (std::size_t i = 0; i < soup.positions.size(); ++i) {
    Vec3& p = soup.positions[i];
    std::size_t best = i;
    for (const std::size_t s : stayed) {
      const double d = distance(soup.positions[s], p);
      if (d > tolerance) continue;
      const double best_distance = best == i ? tolerance * 2 : distance(soup.positions[best], p);
      if (d < best_distance || (d == best_distance && s < best)) best = s;
    }
    if (best == i) {
      stayed.push_back(i);
    } else if (!(p == soup.positions[best])) {
      p = soup.positions[best];
      ++moved;
    }
  }
  return moved;
}

}  // namespace

TEST_CASE("WeldsWithinAToleranceAsComparingWithEveryoneDoes") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (const double tolerance : {1e-9, 0.01, 0.05, 0.2, 1.0, 5.0}) {
    CAPTURE(tolerance);
    TriangleSoup soup;
    for (int i = 0; i < 1500; ++i) {
      soup.positions.push_back({coordinate(random), coordinate(random), coordinate(random)});
    }
    // Some that lie on the grid's own lines, and some far away.
    for (int i = -5; i <= 5; ++i) {
      soup.positions.push_back({2 * tolerance * i, tolerance * i, 0});
      soup.positions.push_back({1e18 + i, -1e18, tolerance * i});
    }
    TriangleSoup expected = soup;
    const std::uint64_t moved = weld_vs_bruteforce(expected, tolerance);
    const auto welded = weld_within(soup, tolerance);
    REQUIRE(welded);
    CHECK(*welded == moved);
    CHECK(soup.positions == expected.positions);
  }
}

TEST_CASE("ARowOfVerticesDoesNotCollapseIntoItsFirst") {
  TriangleSoup soup;
  for (int i = 0; i < 100; ++i) soup.positions.push_back({0.75 * i, 0, 0});
  const TriangleSoup before = soup;
  REQUIRE(weld_within(soup, 1.0));
  for (std::size_t i = 0; i < 100; ++i) {
    CHECK(distance(soup.positions[i], before.positions[i]) <= 1.0);
  }
  CHECK(soup.positions[1] == soup.positions[0]);
  CHECK(soup.positions[2] == before.positions[2]);
}

TEST_CASE("WeldingStopsWhenTold") {
  TriangleSoup soup;
  soup.positions.resize(20'000);
  const auto welded = weld_within(soup, 1.0, Cancel([] { return true; }));
  REQUIRE_FALSE(welded);
  CHECK(welded.error().code == ErrorCode::cancelled);
}

TEST_CASE("CoordinatesBeyondAllBoundsAreLeftForBuildToRefuse") {
  TriangleSoup soup{{{0, 0, 0}, {1e200, 0, 0}, {INFINITY, 0, 0}}, {{0, 1, 2}}};
  CHECK(weld_within(soup, 1.0) == 0);
  CHECK_FALSE(Mesh::build(soup));
}

TEST_CASE("ACoordinateThatIsNoFiniteNumberIsLeftForBuildToRefuse") {
  const std::vector<double Vec3::*> coordinates{&Vec3::x, &Vec3::y, &Vec3::z};
  for (const double bad : {std::nan(""), kInfinity, -kInfinity}) {
    CAPTURE(bad);
    for (double Vec3::*const coordinate : coordinates) {
      for (const std::size_t at : {0, 2, 3}) {
        // Two of the others are near enough to be welded.
        TriangleSoup soup{{{5, 5, 5}, {0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {0.1, 0, 0}},
                          {{1, 2, 3}, {0, 4, 2}}};
        soup.positions[at].*coordinate = bad;
        CHECK(weld_within(soup, 1.0) == 0);
        CHECK(soup.positions[4] == Vec3{0.1, 0, 0});
        CHECK_FALSE(Mesh::build(soup));
      }
    }
  }
}

TEST_CASE("WithoutWeldingFacesAreJoinedByIndicesAlone") {
  const TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                          {{0, 1, 2}, {3, 4, 5}}};
  const auto mesh = Mesh::build(soup, Weld::off);
  REQUIRE(mesh);
  CHECK(mesh->vertex_count() == 6);
  CHECK(mesh->face_count() == 2);
  for (std::uint32_t source = 0; source < 6; ++source) {
    CHECK(mesh->source_of_vertex(mesh->vertex_of_source()[source]) == source);
  }
  const auto adjacency = Adjacency::build(std::make_shared<const Mesh>(*mesh));
  CHECK(adjacency.report().components == 2);
  CHECK(adjacency.report().edges == 6);
}

TEST_CASE("WithoutWeldingAFaceWithTwoCornersInOnePlaceStillJoinsThem") {
  // The middle face is a line from (1, 0) to (1, 1): corners 1 and 3 are one place.
  const TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 0, 0}, {2, 0, 0}},
                          {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}}};
  const auto mesh = Mesh::build(soup, Weld::off);
  REQUIRE(mesh);
  CHECK(mesh->vertex_count() == 4);
  REQUIRE(mesh->dropped_faces().size() == 1);
  CHECK(mesh->dropped_faces()[0].source_face == 1);
  CHECK(mesh->vertex_of_source()[1] == mesh->vertex_of_source()[3]);
  const auto adjacency = Adjacency::build(std::make_shared<const Mesh>(*mesh));
  CHECK(adjacency.report().components == 1);
}

TEST_CASE("WithoutWeldingAMeshOfDistinctPositionsIsTheSame") {
  const TriangleSoup soup = shapes::terrain(20, 3, 1);
  const auto on = Mesh::build(soup);
  const auto off = Mesh::build(soup, Weld::off);
  REQUIRE(on);
  REQUIRE(off);
  CHECK(std::ranges::equal(on->positions(), off->positions()));
  CHECK(std::ranges::equal(on->faces(), off->faces()));
}
