// Fields from lines by the methods that go back by parents, of which two have a wave for each
// source.
#include <doctest/doctest.h>

#include <cstdint>
#include <random>

#include "tests/core/curves/curve_fixtures.h"
#include "tests/fixtures/random_meshes.h"

using namespace geodesic;
using fixtures::ask_some_lines;
using fixtures::LineQuestion;
using fixtures::RandomMesh;
using fixtures::Surface;
using fixtures::test_seed;

TEST_CASE("PathsByParentsFromLinesAreNeverTooShort") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 60; ++round) {
    CAPTURE(round);
    RandomMesh mesh(random());
    const Surface surface(mesh.soup());
    LineQuestion question(surface);
    ask_some_lines(surface, random, question);
    const double rounding = 1e-9 * norm(surface.mesh().box().max - surface.mesh().box().min);
    const Field exact = question.field(Method::exact);
    for (const Method method : {Method::wavefront, Method::novotni, Method::dijkstra}) {
      CAPTURE(int(method));
      const Field field = question.field(method);
      for (std::uint32_t v = 0; v < exact.distance.size(); ++v) {
        CAPTURE(v);
        REQUIRE((field.distance[v] == kUnreached) == (exact.distance[v] == kUnreached));
        if (exact.distance[v] == kUnreached) continue;
        if (random() % 4 != 0) continue;
        const auto path = question.path(field, point_at_vertex(surface.adjacency(), v));
        REQUIRE(path);
        CHECK(path->length >= exact.distance[v] - rounding);
        CHECK(path->points.back().point.vertex == v);
        // Where there is one way alone, along edges, the path has its length.
        if (method == Method::dijkstra) CHECK(path->length <= field.distance[v] + rounding);
      }
    }
  }
}
