// The exact field on scanned meshes, against another implementation's distances.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fixtures/surface.h"
#include "tests/paper/real_meshes.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

// The smallest mesh alone where the code is not optimised, which is ten times slower.
#ifdef NDEBUG
const std::vector<std::string> kMeshes(std::begin(fixtures::kRealMeshes),
                                       std::end(fixtures::kRealMeshes));
#else
const std::vector<std::string> kMeshes{"fandisk_m1"};
#endif

}  // namespace

TEST_CASE("RealMeshesExactDistancesAreTheReferences") {
  for (const std::string& name : kMeshes) {
    CAPTURE(name);
    const auto loaded = fixtures::load_real_mesh(name);
    if (!loaded) {
      MESSAGE("skipped: no ", name, " with its reference; set GEODESIC_SHARED");
      continue;
    }
    REQUIRE(loaded->has_value());
    const std::vector<double>& exact = (*loaded)->exact;
    const Surface surface((*loaded)->soup);
    FieldLimits limits;
    limits.keep_details = false;
    const auto d = surface.in_source_order(
        surface.field_by(Method::exact, {Source{surface.at(0), 0}}, limits));
    // The references are of positions in double precision, ours are rounded to single.
    const double rounding = 1e-7 * norm(surface.mesh().box().max - surface.mesh().box().min);
    double sum = 0;
    double worst = 0;
    std::size_t compared = 0;
    for (std::size_t i = 0; i < d.size(); ++i) {
      if (!fixtures::has_reference(exact[i])) {
        CHECK(d[i] == kUnreached);
        continue;
      }
      REQUIRE(std::isfinite(d[i]));
      if (!(exact[i] > 0)) {
        CHECK(d[i] == 0);
        continue;
      }
      const double error = std::abs(d[i] - exact[i]);
      CHECK(error <= 1e-6 * exact[i] + rounding);
      worst = std::max(worst, error / exact[i]);
      sum += error / exact[i];
      ++compared;
    }
    REQUIRE(compared > 20'000);
    MESSAGE(name, ": mean relative difference ", sum / static_cast<double>(compared), ", worst ",
            worst);
    CHECK(sum <= 1e-7 * static_cast<double>(compared));
  }
}
