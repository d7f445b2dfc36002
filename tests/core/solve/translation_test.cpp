// A surface is the same wherever it lies: moved by what changes no difference of two positions, it
// has the same distances, however far from the origin it comes to lie.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

struct Way {
  const char* name;
  Method method;
  MethodOptions options;
  double same;            // up to this part
  double least_edge = 0;  // but of no less than this
};

std::vector<Way> all_ways() {
  MethodOptions upper;
  upper.bound = Bound::upper;
  MethodOptions within;
  within.error_at_most = 1e-3;
  return {{"wavefront", Method::wavefront, {}, 1e-12},
          {"novotni", Method::novotni, {}, 1e-12},
          {"fast_marching", Method::fast_marching, {}, 1e-12},
          {"dijkstra", Method::dijkstra, {}, 1e-12},
          {"exact", Method::exact, {}, 1e-12},
          {"chen_han", Method::chen_han, {}, 1e-12},
          {"auto", Method::back_traced, {}, 1e-6},  // keeps floats
          {"auto, upper", Method::back_traced, upper, 1e-6},
          {"auto, within 1e-3", Method::back_traced, within, 1e-12},
          // Its points lie on edges in space, to the coordinates' rounding.
          {"steiner", Method::steiner, {}, 1e-6, 1}};
}

}  // namespace

TEST_CASE("DistancesDoNotDependOnWhereTheSurfaceLies") {
  const std::uint32_t seed = fixtures::test_seed();
  CAPTURE(seed);
  std::mt19937 random(seed);
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  // Positions and moves are multiples of this, and their sums are representable.
  constexpr double kGrain = 0x1p-16;
  for (int round = 0; round < 6; ++round) {
    TriangleSoup here = shapes::plane(12, 12);
    for (Vec3& p : here.positions) {
      p = p + kGrain * Vec3{double(below(16384)), double(below(16384)), double(below(65536))};
    }
    const auto move = [&] {
      const double size = std::ldexp(1.0, static_cast<int>(below(46)));  // times the grain: to 2^30
      return kGrain * std::floor(size * (0.5 + below(512) / 1024.0)) * (below(2) == 0 ? 1 : -1);
    };
    Vec3 by{move(), move(), move()};
    if (round == 0) by = {0x1p30, 0x1p30, 0x1p30};
    TriangleSoup there = here;
    for (Vec3& p : there.positions) p = p + by;
    CAPTURE(by.x);
    CAPTURE(by.y);
    CAPTURE(by.z);
    const Surface one(here);
    const Surface other(there);
    const std::uint32_t face = below(static_cast<std::uint32_t>(here.faces.size()));
    const std::array<double, 3> inside{0.1 + below(100), 0.1 + below(100), 0.1 + below(100)};
    const std::array<double, 3> on_edge{0.1 + below(100), 0.1 + below(100), 0};
    const std::uint32_t vertex = below(144);
    for (const Way& way : all_ways()) {
      CAPTURE(way.name);
      for (int kind = 0; kind < 3; ++kind) {
        CAPTURE(kind);
        const auto from = [&](const Surface& surface) {
          const SurfacePoint point = kind == 0   ? surface.at(vertex)
                                     : kind == 1 ? surface.on(face, inside)
                                                 : surface.on(face, on_edge);
          return surface.in_source_order(
              surface.field_by(way.method, {{point, 0}}, {}, way.options));
        };
        const std::vector<double> a = from(one);
        const std::vector<double> b = from(other);
        for (std::size_t v = 0; v < a.size(); ++v) {
          CAPTURE(v);
          CHECK(std::abs(a[v] - b[v]) <= way.same * std::max(a[v], way.least_edge));
        }
      }
    }
  }
}
