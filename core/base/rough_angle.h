// Angles for a tenth of their usual price, to seven digits: for sums and bounds that leave
// room for it.
#pragma once

#include <cmath>
#include <initializer_list>
#include <numbers>

namespace geodesic {

// By how much a rough angle may be off, with room to spare.
inline constexpr double kRoughAngle = 1e-7;

// atan(x) for x from 0 to 1, off by 2e-8 at most. Abramowitz and Stegun 4.4.49.
[[nodiscard]] inline double rough_atan(double x) {
  const double s = x * x;
  double sum = 0.0028662257;
  for (const double a : {-0.0161657367, 0.0429096138, -0.0752896400, 0.1065626393, -0.1420889944,
                         0.1999355085, -0.3333314528, 1.0}) {
    sum = sum * s + a;
  }
  return sum * x;
}

// The angle of the direction (x, y), y not negative, off by 3e-8 at most.
[[nodiscard]] inline double rough_angle(double x, double y) {
  constexpr double kPi = std::numbers::pi;
  const double run = std::abs(x);
  const double acute = y < run ? rough_atan(y / run) : 0.5 * kPi - rough_atan(y > 0 ? run / y : 0);
  return x < 0 ? kPi - acute : acute;
}

}  // namespace geodesic
