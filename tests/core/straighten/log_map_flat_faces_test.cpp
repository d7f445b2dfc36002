// The surface laid into the plane about a point, over faces without width: it is the plane.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "core/straighten/log_map.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/uneven_planes.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;
using fixtures::test_seed;

TEST_CASE("InAPlaneOfFacesWithoutWidthTheMapIsThePlane") {
  std::size_t entries = 0;
  std::size_t straight = 0;
  for (std::uint32_t round = 0; round < 30; ++round) {
    CAPTURE(round);
    RandomMesh random(test_seed() + round);
    TriangleSoup soup = fixtures::plane_of_eighths(random, 4 + random.below(3));
    for (std::uint32_t i = 0; i <= random.below(3); ++i) {
      fixtures::put_flat_faces_in(random, soup);
    }
    const Surface surface(soup);
    if (surface.adjacency().report().edges_non_manifold > 0) continue;
    const Mesh& mesh = surface.mesh();
    std::array<double, 3> bary{random.unit() + 0.01, random.unit() + 0.01, random.unit() + 0.01};
    if (round % 3 > 0) bary[random.below(3)] = 0;
    if (round % 3 > 1) bary = {0, 1, 0};
    const SurfacePoint from = surface.on(random.below(mesh.source_face_count()), bary);
    // Inside a face without width, lines run along it for as long as rounding will have it.
    const bool is_inside = !from.at_vertex() && edge_under(from) == kNone;
    if (is_inside && !(surface.adjacency().face(from.face).area2 > 0)) continue;
    const Field field = surface.field_by(Method::exact, {{from, 0}});
    const auto map = log_map(surface.adjacency(), field, from, kUnreached, Cancel());
    REQUIRE(map.has_value());
    REQUIRE(map->entries.size() == mesh.vertex_count());
    for (const LogMap::Entry& a : map->entries) {
      ++entries;
      // Others pass a vertex, or run along a face without width.
      if (!a.is_straight) continue;
      ++straight;
      for (const LogMap::Entry& b : map->entries) {
        if (!b.is_straight) continue;
        CAPTURE(a.vertex);
        CAPTURE(b.vertex);
        const double there = distance(mesh.positions()[a.vertex], mesh.positions()[b.vertex]);
        CHECK(std::abs(norm(map->coordinates(a) - map->coordinates(b)) - there) < 1e-4);
      }
    }
  }
  CHECK(3 * straight > 2 * entries);
}
