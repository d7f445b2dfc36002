#include "core/solve/distances.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/mesh/shapes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;

TEST_CASE("DistancesAreInTheOrderOfTheFile") {
  // On a plane they are the straight lines, whatever the numbers of its vertices.
  const TriangleSoup soup = shapes::shuffled(shapes::plane(9, 7), 5);
  const auto mesh = Mesh::build(soup);
  REQUIRE(mesh.has_value());
  for (const std::uint32_t from : {0U, 17U, 62U}) {
    const auto result = distances(*mesh, from);
    REQUIRE(result.has_value());
    REQUIRE(result->size() == soup.positions.size());
    for (std::size_t v = 0; v < result->size(); ++v) {
      const double straight = distance(soup.positions[v], soup.positions[from]);
      CHECK(std::abs((*result)[v] - straight) <= 1e-12);
    }
  }
}

TEST_CASE("DistancesByAMethodAreThoseOfItsField") {
  const TriangleSoup soup = shapes::terrain(12, 3, 4);
  const fixtures::Surface surface(soup);
  for (const Method method : {Method::back_traced, Method::wavefront, Method::dijkstra}) {
    const auto result = distances(surface.mesh(), 20, method);
    REQUIRE(result.has_value());
    const Field field = surface.field_by(method, {{surface.at(20), 0}});
    for (std::uint32_t v = 0; v < result->size(); ++v) {
      CHECK((*result)[v] == field.distance[surface.vertex(v)]);
    }
  }
}

TEST_CASE("DistancesFromNoVertexAreAnError") {
  const auto mesh = Mesh::build(shapes::plane(3, 3));
  REQUIRE(mesh.has_value());
  const auto result = distances(*mesh, 9);
  REQUIRE(!result.has_value());
  CHECK(result.error().code == ErrorCode::index_out_of_range);
  CHECK(result.error().limit == 9);
}

TEST_CASE("AScratchCanBeMovedAndMadeNew") {
  const fixtures::Surface surface(shapes::terrain(8, 2, 3));
  const Source source{surface.at(0), 0};
  const auto farthest = [&](SolveScratch& scratch) {
    const auto field =
        solve_field(Method::exact, {}, surface.adjacency(), {&source, 1}, {}, scratch, Cancel());
    REQUIRE(field.has_value());
    return field->max;
  };
  SolveScratch scratch;
  const double first = farthest(scratch);
  SolveScratch other = std::move(scratch);
  CHECK(farthest(other) == first);
  scratch = SolveScratch();
  CHECK(farthest(scratch) == first);
}
