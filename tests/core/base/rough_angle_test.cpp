#include "core/base/rough_angle.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace geodesic;

TEST_CASE("ARoughAngleIsNearTheRealOne") {
  constexpr int kSteps = 100000;
  for (const double scale : {1e-12, 1.0, 1e9}) {
    CAPTURE(scale);
    double most = 0;
    for (int i = 0; i <= kSteps; ++i) {
      const double angle = std::numbers::pi * i / kSteps;
      const double x = scale * std::cos(angle);
      const double y = std::abs(scale * std::sin(angle));
      most = std::max(most, std::abs(rough_angle(x, y) - std::atan2(y, x)));
    }
    CHECK(most <= 3e-8);
    CHECK(most <= kRoughAngle);
  }
}
