// Windows over other faces than the mesh's own, and which faces they are sent over.
#include "core/exact/surface.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/exact/propagation.h"
#include "core/field/vertex_front.h"
#include "core/mesh/shapes.h"
#include "core/surface/intrinsic_delaunay.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;

namespace {

std::vector<double> distances_over(const Triangulation& faces, const Surface& surface,
                                   std::uint32_t source_vertex) {
  const std::vector<Source> sources{{surface.at(source_vertex), 0}};
  Field field = unreached_field(Method::exact, sources, surface.mesh().vertex_count());
  exact::PropagationMemory memory;
  const Cancel never;
  Poll poll(never);
  exact::Propagation propagation(surface.adjacency(), faces, memory, field, kUnreached, 0, false,
                                 poll);
  propagation.start(sources.front(), 0);
  do {
    while (propagation.step()) {
    }
  } while (propagation.relax_along_edges(poll));
  return field.distance.values();
}

Triangulation chosen(const Surface& surface, const std::vector<std::uint32_t>& source_vertices) {
  std::vector<Source> sources;
  for (const std::uint32_t v : source_vertices) sources.push_back({surface.at(v), 0});
  const Cancel never;
  Poll poll(never);
  return exact::surface_for_windows(surface.adjacency(), sources, poll);
}

}  // namespace

TEST_CASE("ExactIsTheSameOverTheMeshAndOverItsDelaunayTriangulation") {
  int different = 0;
  for (std::uint32_t number = 0; number < 150; ++number) {
    CAPTURE(number);
    RandomMesh random(number);
    const std::uint32_t from = random.vertex();
    const Surface surface(random.soup());
    const Triangulation mesh = surface.adjacency().triangulation();
    const Triangulation delaunay = surface.adjacency().delaunay();
    if (mesh.faces.data() == delaunay.faces.data()) continue;
    ++different;
    const std::vector<double> over_mesh = distances_over(mesh, surface, from);
    const std::vector<double> over_delaunay = distances_over(delaunay, surface, from);
    double worst = 0;
    for (std::size_t v = 0; v < over_mesh.size(); ++v) {
      REQUIRE((over_mesh[v] == kUnreached) == (over_delaunay[v] == kUnreached));
      if (over_mesh[v] == kUnreached || over_mesh[v] == 0) continue;
      worst = std::max(worst, std::abs(over_delaunay[v] / over_mesh[v] - 1));
    }
    CHECK(worst < 1e-11);
  }
  CHECK(different > 80);
}

TEST_CASE("WindowsGoOverTheFacesThatPathsCrossFewerEdgesOf") {
  constexpr std::uint32_t kSide = 40;
  TriangleSoup soup = shapes::terrain(kSide, 4, 1);
  for (Vec3& p : soup.positions) p.y *= 8;
  const Surface surface(soup);
  const Triangulation mesh = surface.adjacency().triangulation();
  const Triangulation delaunay = surface.adjacency().delaunay();
  REQUIRE(mesh.faces.data() != delaunay.faces.data());
  // From vertices all along a side of the terrain, paths run straight away from it.
  std::vector<std::uint32_t> least_x;
  std::vector<std::uint32_t> least_y;
  for (std::uint32_t i = 2; i < kSide; i += 5) {
    const auto nearest = [&](double x, double y) {
      std::uint32_t best = 0;
      for (std::uint32_t v = 0; v < soup.positions.size(); ++v) {
        const auto off = [&](const Vec3& p) { return std::hypot(p.x - x, p.y - y); };
        if (off(soup.positions[v]) < off(soup.positions[best])) best = v;
      }
      return best;
    };
    least_x.push_back(nearest(0, 8.0 * i));
    least_y.push_back(nearest(i, 0));
  }
  CHECK(chosen(surface, least_x).faces.data() == delaunay.faces.data());
  CHECK(chosen(surface, least_y).faces.data() == mesh.faces.data());
}
