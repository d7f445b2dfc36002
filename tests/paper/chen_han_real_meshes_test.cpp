// Chen and Han's exact distances against those of another exact code, on scanned
// meshes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/fixtures/surface.h"
#include "tests/paper/real_meshes.h"

using namespace geodesic;
using fixtures::has_reference;
using fixtures::load_real_mesh;
using fixtures::Surface;

TEST_CASE("RealMeshesChenHanIsExact") {
  for (const std::string name : {"fandisk_m1", "bunny35k"}) {
    CAPTURE(name);
    const auto loaded = load_real_mesh(name);
    if (!loaded) {
      MESSAGE("skipped: no ", name, " with its reference; set GEODESIC_SHARED");
      continue;
    }
    REQUIRE(loaded->has_value());
    const fixtures::RealMesh& real = **loaded;
    const Surface surface(real.soup);
    const double size = distance(surface.mesh().box().min, surface.mesh().box().max);
    double farthest = 0;
    for (const double exact : real.exact) {
      if (has_reference(exact)) farthest = std::max(farthest, exact);
    }
    FieldLimits limits;
    limits.max = 0.5 * farthest;
    limits.keep_details = false;
    const Field field = surface.field_by(Method::chen_han, {Source{surface.at(0), 0}}, limits);
    const auto distances = surface.in_source_order(field);
    double worst = 0;
    double sum = 0;
    std::size_t compared = 0;
    for (std::size_t v = 0; v < distances.size(); ++v) {
      const double exact = real.exact[v];
      if (!has_reference(exact) || !(exact > 0) || exact > limits.max * (1 - 1e-6)) continue;
      REQUIRE(std::isfinite(distances[v]));
      const double error = std::abs(distances[v] - exact);
      worst = std::max(worst, error / size);
      sum += error / exact;
      ++compared;
    }
    REQUIRE(compared > 5'000);
    const double mean = sum / static_cast<double>(compared);
    MESSAGE(name, ": ", compared, " vertices, mean relative error ", mean, ", worst ", worst,
            " of the mesh's size");
    // The references are of double positions, the meshes have floats.
    CHECK(mean < 2e-7);
    CHECK(worst < 1e-6);
  }
}
