#include "core/solve/farthest_points.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

FarthestPoints points_of(const Surface& surface, const std::vector<Source>& from, std::size_t count,
                         Method method = Method::wavefront) {
  SolveScratch scratch;
  auto result = farthest_points(method, {}, surface.adjacency(), from, count, scratch, Cancel());
  REQUIRE(result);
  return std::move(*result);
}

// The oracle: whole fields from every point so far, and the definition.
void check_against_whole_fields(const Surface& surface, const std::vector<Source>& from,
                                const FarthestPoints& result, Method method) {
  std::vector<double> nearest(surface.mesh().vertex_count(), kUnreached);
  const auto lower = [&](const std::vector<Source>& sources) {
    const Field field = surface.field_by(method, sources);
    for (std::size_t v = 0; v < nearest.size(); ++v) {
      nearest[v] = std::min(nearest[v], field.distance[v]);
    }
  };
  const auto greatest = [&] {
    double most = 0;
    for (std::uint32_t v = 0; v < nearest.size(); ++v) {
      if (!surface.adjacency().corners(v).empty()) most = std::max(most, nearest[v]);
    }
    return most;
  };
  if (!from.empty()) lower(from);
  for (const FarthestPoint& point : result.points) {
    CHECK(point.radius == greatest());
    CHECK(nearest[point.vertex] == point.radius);
    lower({Source{point_at_vertex(surface.adjacency(), point.vertex), 0}});
  }
  CHECK(result.covering_radius == greatest());
}

}  // namespace

TEST_CASE("FarthestPointsOnAStripHalveIt") {
  const Surface surface(shapes::plane(101, 2));
  const auto result = points_of(surface, {}, 4);
  REQUIRE(result.points.size() == 4);
  const std::vector<std::uint32_t> expected{0, 201, 50, 126};
  const std::vector<double> radius{0, std::hypot(100, 1), 50, std::hypot(25, 1)};
  CHECK(result.points[0].radius == kUnreached);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(result.points[i].vertex == surface.vertex(expected[i]));
    if (i > 0) CHECK(result.points[i].radius == doctest::Approx(radius[i]));
  }
  CHECK(result.covering_radius == doctest::Approx(25));
}

TEST_CASE("FarthestPointsVsWholeFields") {
  for (const Method method : {Method::wavefront, Method::dijkstra}) {
    for (std::uint32_t number = 0; number < 12; ++number) {
      CAPTURE(number);
      fixtures::RandomMesh mesh(number);
      const Surface surface(mesh.soup());
      const std::vector<Source> from{Source{surface.at(mesh.vertex()), 0}};
      check_against_whole_fields(surface, {}, points_of(surface, {}, 12, method), method);
      check_against_whole_fields(surface, from, points_of(surface, from, 8, method), method);
    }
  }
}

TEST_CASE("FarthestPointsOfAwkwardMeshes") {
  for (const auto& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    const auto result = points_of(surface, {}, 6);
    check_against_whole_fields(surface, {}, result, Method::wavefront);
    for (std::size_t i = 2; i < result.points.size(); ++i) {
      CHECK(result.points[i].radius <= result.points[i - 1].radius);
    }
  }
}

TEST_CASE("UnreachedComponentsComeFirst") {
  const Surface surface(fixtures::two_components());
  const auto result = points_of(surface, {}, 3);
  REQUIRE(result.points.size() == 3);
  CHECK(result.points[0].vertex == surface.vertex(0));
  CHECK(result.points[0].radius == kUnreached);
  CHECK(result.points[1].vertex == surface.vertex(25));
  CHECK(result.points[1].radius == kUnreached);
  CHECK(result.points[2].vertex == surface.vertex(24));
  CHECK(result.points[2].radius == doctest::Approx(std::hypot(4, 4)));
  CHECK(points_of(surface, {}, 1).covering_radius == kUnreached);
}

TEST_CASE("FarthestPointsAreFewerOnceAllVerticesAre") {
  const Surface surface(fixtures::single_triangle());
  const auto result = points_of(surface, {}, 10);
  CHECK(result.points.size() == 3);
  CHECK(result.covering_radius == 0);
}

TEST_CASE("GivenPointsAreCoveredAndNotChosen") {
  const Surface surface(shapes::plane(11, 11));
  const Source middle{surface.on(110, {0.2, 0.3, 0.5}), 0};
  const auto none = points_of(surface, {middle}, 0);
  CHECK(none.points.empty());
  CHECK(none.covering_radius == surface.field({middle}).max);
  const auto one = points_of(surface, {Source{surface.at(0), 0}}, 1);
  REQUIRE(one.points.size() == 1);
  CHECK(one.points[0].vertex == surface.vertex(120));
  CHECK(one.points[0].radius == doctest::Approx(std::hypot(10, 10)));
}

TEST_CASE("VerticesInNoFaceAreNotChosen") {
  const std::vector<shapes::Hole> holes{{0, 0, 3}};  // takes the corner vertex 0 with it
  const Surface surface(shapes::plane_with_holes(8, 8, holes));
  const auto result = points_of(surface, {}, 64);
  CHECK(result.points.size() < 64);
  CHECK(result.covering_radius == 0);
  for (const FarthestPoint& point : result.points) {
    CHECK_FALSE(surface.adjacency().corners(point.vertex).empty());
  }
  CHECK(result.points[0].vertex == surface.vertex(3));
}

TEST_CASE("FarthestPointsStopWhenCancelled") {
  const Surface surface(shapes::plane(10, 10));
  SolveScratch scratch;
  int asked = 0;
  const Cancel third([&] { return ++asked == 3; });
  const auto stopped =
      farthest_points(Method::wavefront, {}, surface.adjacency(), {}, 50, scratch, third);
  REQUIRE_FALSE(stopped);
  CHECK(stopped.error().code == ErrorCode::cancelled);
}
