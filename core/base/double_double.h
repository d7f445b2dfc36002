// Numbers of two doubles: 106 bits instead of 53, for the few places where rounding piles up.
// Dekker, "A floating-point technique for extending the available precision", Numerische Mathematik
// 18, 1971; Hida, Li, Bailey, "Algorithms for quad-double precision floating point arithmetic",
// ARITH 2001, section 3. Wants a compiler that does not contract a * b + c into one operation.
#pragma once

#include <cmath>

namespace geodesic {

// high + low, where low is at most half a unit in the last place of high.
struct DoubleDouble {
  double high = 0;
  double low = 0;

  constexpr DoubleDouble() = default;
  constexpr DoubleDouble(double value) : high(value) {}  // NOLINT(google-explicit-constructor)
  constexpr DoubleDouble(double h, double l) : high(h), low(l) {}

  // a + b without rounding, where |a| >= |b|.
  [[nodiscard]] static constexpr DoubleDouble ordered_sum(double a, double b) {
    const double sum = a + b;
    return {sum, b - (sum - a)};
  }
  // a + b without rounding.
  [[nodiscard]] static constexpr DoubleDouble sum(double a, double b) {
    const double sum = a + b;
    const double of_b = sum - a;
    return {sum, (a - (sum - of_b)) + (b - of_b)};
  }
  // a * b without rounding, where neither is above 1e290 nor the product below 1e-270.
  [[nodiscard]] static constexpr DoubleDouble product(double a, double b) {
    constexpr double kSplit = 134217729;  // 2^27 + 1: halves of 26 bits
    const double a_split = kSplit * a;
    const double a_high = a_split - (a_split - a);
    const double a_low = a - a_high;
    const double b_split = kSplit * b;
    const double b_high = b_split - (b_split - b);
    const double b_low = b - b_high;
    const double product = a * b;
    return {product,
            ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
  }
};

// Relative errors are below 2^-102.
[[nodiscard]] constexpr DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  DoubleDouble high = DoubleDouble::sum(a.high, b.high);
  const DoubleDouble low = DoubleDouble::sum(a.low, b.low);
  high = DoubleDouble::ordered_sum(high.high, high.low + low.high);
  return DoubleDouble::ordered_sum(high.high, high.low + low.low);
}
[[nodiscard]] constexpr DoubleDouble operator-(DoubleDouble a) { return {-a.high, -a.low}; }
[[nodiscard]] constexpr DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + -b; }
[[nodiscard]] constexpr DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble high = DoubleDouble::product(a.high, b.high);
  return DoubleDouble::ordered_sum(high.high, high.low + (a.high * b.low + a.low * b.high));
}
// b is not zero.
[[nodiscard]] constexpr DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
  const double first = a.high / b.high;
  const DoubleDouble left = a - b * first;
  const double second = left.high / b.high;
  const double third = (left - b * second).high / b.high;
  return DoubleDouble::ordered_sum(first, second) + third;
}
// Zero for what is below zero.
[[nodiscard]] inline DoubleDouble square_root(DoubleDouble a) {
  if (!(a.high > 0)) return 0;
  const double near = std::sqrt(a.high);
  const double rest = (a - DoubleDouble::product(near, near)).high;
  return DoubleDouble::ordered_sum(near, rest / (2 * near));
}

}  // namespace geodesic
