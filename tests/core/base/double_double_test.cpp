#include "core/base/double_double.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "tests/fixtures/test_seed.h"

using namespace geodesic;

#if defined(__SIZEOF_FLOAT128__)

namespace {

__extension__ using Quadruple = __float128;

Quadruple exact(DoubleDouble a) { return Quadruple(a.high) + a.low; }

// Off by so much of the truth.
double off(DoubleDouble a, Quadruple truth) {
  const auto difference = static_cast<double>(exact(a) - truth);
  return std::abs(difference / static_cast<double>(truth));
}

}  // namespace

TEST_CASE("TwoDoublesAreAsGoodAsAHundredBits") {
  std::mt19937 random(fixtures::test_seed());
  std::uniform_real_distribution<double> mantissa(-1, 1);
  std::uniform_int_distribution<int> exponent(-60, 60);
  const auto number = [&] {
    const double high = std::ldexp(mantissa(random), exponent(random));
    return DoubleDouble::sum(high, high * 0x1p-54 * mantissa(random));
  };
  for (int i = 0; i < 20000; ++i) {
    const DoubleDouble a = number();
    const DoubleDouble b = number();
    CAPTURE(a.high);
    CAPTURE(b.high);
    CHECK(off(a + b, exact(a) + exact(b)) < 0x1p-100);
    CHECK(off(a * b, exact(a) * exact(b)) < 0x1p-100);
    CHECK(off(a / b, exact(a) / exact(b)) < 0x1p-98);
    // Nearly opposite: what is left is off by no more than the two were.
    const DoubleDouble near{-a.high, a.low / 2};
    CHECK(std::abs((a + near).high - 1.5 * a.low) <= 0x1p-104 * std::abs(a.high));
    const DoubleDouble square = a * a;
    const DoubleDouble root = square_root(square);
    CHECK(off(root * root, exact(square)) < 0x1p-98);
  }
  CHECK(square_root(-1.0).high == 0);
  CHECK(square_root(0.0).high == 0);
}

#endif
