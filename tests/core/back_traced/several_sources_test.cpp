// The least of several waves: what one of them says of a vertex must not hide what another one
// does.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/faces_thrown_together.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
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

// Each wave stops where another source is nearer. What it has not seen there is of no use to it.
TEST_CASE("DistancesFromManySourcesAreTheLeastFromEachAlone") {
  std::mt19937 random(fixtures::test_seed());
  TriangleSoup stretched = shapes::terrain(60, 6, random());
  for (Vec3& p : stretched.positions) p.x *= 4;
  std::vector<TriangleSoup> soups{shapes::terrain(70, 10, random()), std::move(stretched),
                                  shapes::torus_knot(200, 16, 0.4), shapes::icosphere(4)};
  std::shuffle(soups.begin(), soups.end(), random);
  soups.resize(fixtures::all_or<std::size_t>(soups.size(), 1));
  for (const TriangleSoup& soup : soups) {
    const Surface surface(soup);
    const auto vertices = static_cast<std::uint32_t>(surface.mesh().vertex_count());
    for (const std::size_t count : {3, 12, 60}) {
      CAPTURE(count);
      std::vector<Source> sources;
      for (std::size_t i = 0; i < count; ++i) {
        const auto v = static_cast<std::uint32_t>(random() % vertices);
        sources.push_back({point_at_vertex(surface.adjacency(), v), 0});
      }
      std::vector<double> least(vertices, kUnreached);
      for (const Source& source : sources) {
        const Field alone = surface.field_by(Method::back_traced, {source});
        for (std::uint32_t v = 0; v < vertices; ++v) {
          least[v] = std::min(least[v], alone.distance[v]);
        }
      }
      const Field together = surface.field_by(Method::back_traced, sources);
      double greatest = 0;
      double sum = 0;
      std::uint32_t others = 0;
      for (std::uint32_t v = 0; v < vertices; ++v) {
        if (least[v] == 0) continue;
        const double off = std::abs(together.distance[v] / least[v] - 1);
        greatest = std::max(greatest, off);
        sum += off;
        if (off > 1e-6) ++others;
      }
      MESSAGE(count, " sources: ", others, " of ", vertices, " differ, by at most ", greatest);
      CHECK(sum < 1e-4 * vertices);
      CHECK(greatest < 0.03);
    }
  }
}
