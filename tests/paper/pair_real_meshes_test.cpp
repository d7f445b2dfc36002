// Pairs of points on scanned meshes, searched for: as from whole fields, and against the
// reference's exact distances.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>

#include "core/solve/pair_search.h"
#include "core/straighten/refine_path.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/surface.h"
#include "tests/paper/real_meshes.h"

using namespace geodesic;
using fixtures::has_reference;
using fixtures::load_real_mesh;
using fixtures::Surface;

namespace {

Pair searched(const Surface& surface, Method method, const SurfacePoint& from,
              const SurfacePoint& to) {
  SolveScratch scratch;
  auto pair = pair_search(method, {}, surface.adjacency(), {from, 0}, to, PairPath::traced, scratch,
                          Cancel());
  REQUIRE(pair);
  REQUIRE(pair->path);
  return std::move(*pair);
}

}  // namespace

TEST_CASE("PairsOnScansAreAsFromWholeFields") {
  for (const std::string name : fixtures::kRealMeshes) {
    CAPTURE(name);
    const auto loaded = load_real_mesh(name);
    if (!loaded) {
      MESSAGE("skipped: no ", name, " with its reference; set GEODESIC_SHARED");
      continue;
    }
    REQUIRE(loaded->has_value());
    const auto& real = **loaded;
    const Surface surface(real.soup);
    const double size = distance(surface.mesh().box().min, surface.mesh().box().max);
    std::mt19937 random(3);
    const auto any_source_vertex = [&] {
      std::size_t v = 0;
      do {
        v = random() % real.exact.size();
      } while (!has_reference(real.exact[v]) || real.exact[v] == 0);
      return static_cast<std::uint32_t>(v);
    };
    for (const Method method : {Method::wavefront, Method::back_traced, Method::dijkstra}) {
      CAPTURE(static_cast<int>(method));
      for (int i = 0; i < 5; ++i) {
        const SurfacePoint from = surface.at(any_source_vertex());
        const Field whole = surface.field_by(method, {Source{from, 0}});
        for (int k = 0; k < 5; ++k) {
          const SurfacePoint to = surface.at(any_source_vertex());
          const Pair pair = searched(surface, method, from, to);
          CHECK(pair.distance == whole.distance[to.vertex]);
          const auto path =
              path_through(surface.adjacency(), whole, to, PathWork::traced, Cancel());
          REQUIRE(path);
          REQUIRE(*path);
          // The shortest ways along edges may be several.
          if (method != Method::dijkstra) CHECK(pair.path->length == (*path)->length);
          fixtures::check_is_a_path(surface.adjacency(), *pair.path, size);
        }
      }
    }
    const Field exact = surface.field_by(Method::exact, {Source{surface.at(0), 0}});
    for (int i = 0; i < 10; ++i) {
      const std::uint32_t to = any_source_vertex();
      const Pair pair = searched(surface, Method::exact, surface.at(0), surface.at(to));
      CHECK(std::abs(pair.distance / exact.distance[surface.vertex(to)] - 1) < 1e-12);
      CHECK(std::abs(pair.path->length / pair.distance - 1) < 1e-9);
      // The reference is rounded.
      CHECK(std::abs(pair.distance - real.exact[to]) <= 1e-6 * real.exact[to] + 1e-7 * size);
      fixtures::check_is_a_path(surface.adjacency(), *pair.path, size);
    }
  }
}
