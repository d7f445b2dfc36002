// The least of several waves: what one of them says of a vertex must not hide what another one
// does.
#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "tests/fixtures/faces_thrown_together.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

void check_not_above_ways_along_edges(std::mt19937& random, const Surface& surface) {
  std::vector<Source> sources;
  const std::size_t count = 2 + random() % 3;
  const auto vertices = surface.mesh().vertex_count();
  const double size = norm(surface.mesh().box().max - surface.mesh().box().min);
  for (std::size_t i = 0; i < count; ++i) {
    const double offset =
        random() % 2 == 0 ? 0 : std::uniform_real_distribution<double>(0, size)(random);
    if (random() % 3 == 0) {
      const auto face = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
      sources.push_back({{face, {0.5, 0.3, 0.2}, kNone}, offset});
    } else {
      const auto v = static_cast<std::uint32_t>(random() % vertices);
      sources.push_back({point_at_vertex(surface.adjacency(), v), offset});
    }
  }
  const Field field = surface.field_by(Method::back_traced, sources);
  const Field along_edges = surface.field_by(Method::dijkstra, sources);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    CAPTURE(v);
    CHECK(field.distance[v] <= along_edges.distance[v] * (1 + 1e-6));
  }
}

}  // namespace

TEST_CASE("NoDistanceFromSeveralSourcesIsAboveTheWayAlongEdges") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < 600; ++round) {
    CAPTURE(round);
    const int faces = 20 + static_cast<int>(random() % 80);
    check_not_above_ways_along_edges(random,
                                     Surface(fixtures::faces_thrown_together(random, faces)));
  }
}
