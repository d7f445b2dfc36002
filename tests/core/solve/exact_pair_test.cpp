// The exact way between two points with few windows kept, against all windows kept.
#include "core/solve/exact_pair.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/field/window_table.h"
#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "core/paths/trace_path.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;

namespace {

TriangleSoup bumpy(std::uint32_t side, double height) {
  TriangleSoup soup = shapes::plane(side, side);
  for (Vec3& p : soup.positions) {
    const double x = 10 * p.x / side;
    const double y = 10 * p.y / side;
    p = {x, y, height * (0.6 * std::sin(3 * x) * std::cos(2 * y) + 0.1 * std::sin(17 * x + 3 * y))};
  }
  return soup;
}

SurfacePoint any_point(const Adjacency& adjacency, std::mt19937& random) {
  const auto f = static_cast<std::uint32_t>(random() % adjacency.mesh().face_count());
  const std::vector<std::array<double, 3>> places{
      {1, 0, 0}, {0, 0.5, 0.5}, {0.2, 0.3, 0.5}, {1e-9, 0.4, 0.6 - 1e-9}};
  return point_on_face(adjacency, f, places[random() % places.size()]);
}

}  // namespace

TEST_CASE("ExactPairsWithFewWindowsAreThoseWithAll") {
  std::mt19937 random(fixtures::test_seed());
  std::vector<TriangleSoup> soups{bumpy(40, 1),
                                  bumpy(30, 4),
                                  shapes::terrain(40, 6, 3),
                                  shapes::icosphere(3),
                                  shapes::torus_knot(60, 8, 0.3),
                                  shapes::plane(20, 20)};
  for (std::size_t i = 0; i < soups.size(); ++i) {
    CAPTURE(i);
    const auto adjacency =
        Adjacency::build(std::make_shared<const Mesh>(std::move(*Mesh::build(soups[i]))));
    ExactScratch scratch;
    for (int trial = 0; trial < fixtures::all_or(40, 8); ++trial) {
      CAPTURE(trial);
      const Source from{any_point(adjacency, random), random() % 2 == 0 ? 0.0 : 0.5};
      const SurfacePoint to = any_point(adjacency, random);
      const auto field = exact_field(adjacency, {&from, 1}, {}, scratch, Cancel());
      REQUIRE(field);
      const double wanted = PointArrivals(adjacency, *field).distance_at(to);
      const auto distance = exact_pair(adjacency, from, to, false, scratch, Cancel());
      REQUIRE(distance);
      CHECK(std::abs(distance->distance - wanted) <= 1e-12 * wanted);
      CHECK_FALSE(distance->path);
      const auto pair = exact_pair(adjacency, from, to, true, scratch, Cancel());
      REQUIRE(pair);
      CHECK(pair->distance == distance->distance);
      REQUIRE(pair->path);
      CHECK(std::abs(from.offset + pair->path->length - wanted) <= 1e-9 * wanted);
    }
  }
}

// However much later it sets out, the shortest path is the same.
TEST_CASE("AnOffsetChangesNoExactPair") {
  std::mt19937 random(fixtures::test_seed());
  constexpr double kLater = 1e12;
  for (const TriangleSoup& soup : {bumpy(30, 2), shapes::terrain(30, 6, 3)}) {
    const auto adjacency =
        Adjacency::build(std::make_shared<const Mesh>(std::move(*Mesh::build(soup))));
    ExactScratch scratch;
    for (int trial = 0; trial < fixtures::all_or(10, 3); ++trial) {
      CAPTURE(trial);
      const SurfacePoint from = any_point(adjacency, random);
      const SurfacePoint to = any_point(adjacency, random);
      const auto soon = exact_pair(adjacency, {from, 0}, to, true, scratch, Cancel());
      const auto late = exact_pair(adjacency, {from, kLater}, to, true, scratch, Cancel());
      REQUIRE((soon && late));
      CHECK(late->distance == kLater + soon->distance);
      REQUIRE((soon->path && late->path));
      CHECK(std::abs(soon->path->length - soon->distance) <= 1e-9 * soon->distance);
      CHECK(std::abs(late->path->length - soon->distance) <= 1e-9 * soon->distance);
    }
  }
}

TEST_CASE("ExactPairsKeepFewWindows") {
  const auto adjacency =
      Adjacency::build(std::make_shared<const Mesh>(std::move(*Mesh::build(bumpy(120, 1)))));
  const Source from{point_on_face(adjacency, 5, {0.3, 0.3, 0.4}), 0};
  const SurfacePoint to =
      point_on_face(adjacency, adjacency.mesh().face_count() - 5, {0.2, 0.3, 0.5});
  ExactScratch scratch;
  const auto all = exact_field(adjacency, {&from, 1}, {}, scratch, Cancel());
  REQUIRE(all);
  FieldLimits limits;
  const std::vector<std::uint32_t> faces{to.face};
  limits.detail_faces = faces;
  const auto few = exact_field(adjacency, {&from, 1}, limits, scratch, Cancel());
  REQUIRE(few);
  CHECK(few->distance.values() == all->distance.values());
  CHECK(PointArrivals(adjacency, *few).distance_at(to) ==
        PointArrivals(adjacency, *all).distance_at(to));
  CHECK(few->windows->size() < all->windows->size() / 1000);
}

TEST_CASE("ExactPairsWithoutAPathHaveNone") {
  TriangleSoup soup = shapes::plane(5, 5);
  const auto count = static_cast<std::uint32_t>(soup.positions.size());
  for (const Vec3 p : {Vec3{50, 0, 0}, Vec3{51, 0, 0}, Vec3{50, 1, 0}}) soup.positions.push_back(p);
  soup.faces.push_back({count, count + 1, count + 2});
  const auto adjacency =
      Adjacency::build(std::make_shared<const Mesh>(std::move(*Mesh::build(soup))));
  const Source from{point_on_face(adjacency, 0, {0.3, 0.3, 0.4}), 0};
  const std::uint32_t apart =
      adjacency.mesh().face_of_source(adjacency.mesh().source_face_count() - 1);
  const SurfacePoint to = point_on_face(adjacency, apart, {0.3, 0.3, 0.4});
  ExactScratch scratch;
  const auto none = exact_pair(adjacency, from, to, true, scratch, Cancel());
  REQUIRE(none);
  CHECK(none->distance == kUnreached);
  CHECK_FALSE(none->path);
}

// The faces near the path are gathered without going through a vertex's faces once for each.
TEST_CASE("AnExactPairEndsOnAFanOfManyFaces") {
  std::mt19937 random(fixtures::test_seed());
  const auto rim = static_cast<std::uint32_t>(80'000 + random() % 1000);
  TriangleSoup soup;
  soup.positions.push_back({0, 0, 0.5});
  for (std::uint32_t i = 0; i < rim; ++i) {
    const double angle = 2 * 3.14159265358979 * i / rim;
    soup.positions.push_back({std::cos(angle), std::sin(angle), 0});
    soup.faces.push_back({0, 1 + i, 1 + (i + 1) % rim});
  }
  const auto adjacency =
      Adjacency::build(std::make_shared<const Mesh>(std::move(*Mesh::build(soup))));
  ExactScratch scratch;
  const Source from{point_at_vertex(adjacency, 1)};
  const SurfacePoint to = point_at_vertex(adjacency, 1 + rim / 3);
  const auto pair = exact_pair(adjacency, from, to, true, scratch, Cancel());
  REQUIRE(pair);
  REQUIRE(pair->path);
  CHECK(pair->path->length == doctest::Approx(pair->distance).epsilon(1e-9));
  // And leaves off when it is told to, wherever it is.
  for (int trial = 0; trial < 6; ++trial) {
    int left = static_cast<int>(random() % 100);
    CAPTURE(left);
    const auto stopped =
        exact_pair(adjacency, from, to, true, scratch, Cancel([&] { return left-- <= 0; }));
    if (left > 0) continue;  // it ended before
    REQUIRE_FALSE(stopped);
    CHECK(stopped.error().code == ErrorCode::cancelled);
  }
}
