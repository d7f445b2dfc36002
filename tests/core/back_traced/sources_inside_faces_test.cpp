// Distances from where people click: nearly always inside a face.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

// Of the distances by `auto` from one source, by those that are exact.
struct Off {
  double mean = 0;
  double largest = 0;
  double below = 0;  // the most
};

Off off_from(const Surface& surface, const SurfacePoint& source, Bound bound) {
  MethodOptions options;
  options.bound = bound;
  const Field found = surface.field_by(Method::back_traced, {Source{source, 0}}, {}, options);
  const Field truth = surface.field_by(Method::exact, {Source{source, 0}});
  Off off;
  std::size_t count = 0;
  for (std::size_t v = 0; v < truth.distance.size(); ++v) {
    if (!(truth.distance[v] > 0) || truth.distance[v] == kUnreached) continue;
    const double error = found.distance[v] / truth.distance[v] - 1;
    off.mean += std::abs(error);
    off.largest = std::max(off.largest, std::abs(error));
    off.below = std::max(off.below, -error);
    ++count;
  }
  off.mean /= static_cast<double>(count);
  return off;
}

}  // namespace

// Their front starts on the mesh's own faces and goes on over others. If it stayed on the mesh's,
// most means would be 3 to 30 times those from vertices.
TEST_CASE("FromInsideFacesDistancesAreAsGoodAsFromVertices") {
  std::mt19937 random(fixtures::test_seed());
  TriangleSoup stretched = shapes::terrain(70, 6, random());
  for (Vec3& p : stretched.positions) p.x *= 8;
  std::vector<std::pair<std::string, TriangleSoup>> soups{
      {"terrain", shapes::terrain(90, 12, random())},
      {"stretched terrain", std::move(stretched)},
      {"knot", shapes::torus_knot(240, 16, 0.4)},
      {"saddle", shapes::saddle(80, 30)},
      {"sphere", shapes::icosphere(4)}};
  std::shuffle(soups.begin(), soups.end(), random);
  soups.resize(fixtures::all_or<std::size_t>(soups.size(), 1));
  for (const auto& [name, soup] : soups) {
    CAPTURE(name);
    const Surface surface(soup);
    const auto faces = static_cast<std::uint32_t>(surface.mesh().faces().size());
    std::uniform_real_distribution<double> share(0.05, 0.9);
    constexpr int kSources = fixtures::all_or(5, 2);
    for (const Bound bound : {Bound::none, Bound::upper}) {
      double inside = 0;
      double at_vertices = 0;
      double largest = 0;
      for (int i = 0; i < kSources; ++i) {
        const auto vertex = static_cast<std::uint32_t>(random() % soup.positions.size());
        const Off at_vertex = off_from(surface, surface.at(vertex), bound);
        at_vertices += at_vertex.mean / kSources;
        const double first = i == 0 ? 0 : share(random);  // the first lies on an edge
        const double second = (1 - first) * share(random);
        const Off off = off_from(
            surface, surface.on(random() % faces, {first, second, 1 - first - second}), bound);
        inside += off.mean / kSources;
        largest = std::max({largest, off.largest, at_vertex.largest});
        if (bound == Bound::upper) CHECK(off.below < 1e-6);
      }
      MESSAGE(name, std::string(bound == Bound::upper ? ", upper" : ""), ": inside faces ",
              100 * inside, " %, at vertices ", 100 * at_vertices, " %, the largest of both ",
              100 * largest, " %");
      if (!fixtures::kSanitized) CHECK(inside < 2.5 * at_vertices + 5e-5);
    }
  }
}
