#include "core/back_traced/relax_edges.h"

#include <doctest/doctest.h>

#include <cstdint>

#include "core/mesh/shapes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

// As badly as can be: all are too far by far, and thin triangles make many ways of nearly
// the same length. Lowered in any other order than the nearest first, some would be lowered
// hundreds of times.
TEST_CASE("AFieldThatIsTooFarEverywhereIsThatOfEdgesAndCostsLittle") {
  TriangleSoup soup = shapes::shuffled(shapes::terrain(60, 3, 1), 5);
  for (Vec3& p : soup.positions) p.x *= 30;
  const Surface surface(soup);
  const Field expected = surface.field_by(Method::dijkstra, {Source{surface.at(7), 0}});
  Field field = expected;
  for (double& d : field.distance.doubles()) d = d > 0 ? 1e9 : 0;
  std::uint64_t steps = 0;
  const Cancel count([&steps] {
    ++steps;
    return false;
  });
  Poll poll(count, 1);
  relax_edges(surface.adjacency(), kUnreached, field, poll);
  for (std::size_t v = 0; v < expected.distance.size(); ++v) {
    CHECK(field.distance[v] == doctest::Approx(expected.distance[v]).epsilon(1e-12));
  }
  // One a face, and one each time that a vertex is lowered.
  CHECK(steps < 4 * surface.mesh().faces().size());
}
