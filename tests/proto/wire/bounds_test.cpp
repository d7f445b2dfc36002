// An upper bound stays one in every format: what is cut off or rounded is rounded up.
#include <doctest/doctest.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "proto/wire/array_formats.h"
#include "proto/wire/number.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;

namespace {

// Of any size, often close to a number of few digits from either side.
double random_distance(std::mt19937_64& random) {
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
  double value = unit() * std::pow(10.0, std::floor(unit() * 40) - 20);
  if (random() % 2 == 0) {
    std::string few;
    proto::append_number(few, value, 1 + static_cast<int>(random() % 9));
    value = *proto::parse_finite(few);
    const auto steps = static_cast<int>(random() % 3);
    for (int i = 0; i < steps; ++i) value = std::nextafter(value, random() % 2 == 0 ? 0 : 1e300);
  }
  return value;
}

double read_back(double value, int digits, Bound bound) {
  std::string text;
  proto::append_bound(text, value, digits, bound);
  const auto number = proto::parse_finite(text);
  REQUIRE(number);
  return *number;
}

template <class T>
std::vector<T> numbers(const std::string& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

}  // namespace

TEST_CASE("FiniteCostsBeyondFloatsStayFinitee") {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> values{1e300, 1, infinity};
  const auto floats = numbers<float>(proto::f32_bytes(values));
  CHECK(floats[0] == std::numeric_limits<float>::max());
  CHECK(floats[1] == 1);
  CHECK(floats[2] == infinity);
}

TEST_CASE("ABoundInFewDigitsIsNotBelowAndNoFartherThanOneOfTheLast") {
  std::mt19937_64 random(fixtures::test_seed());
  for (int round = 0; round < 20'000; ++round) {
    const double value = random_distance(random);
    const int digits = 1 + static_cast<int>(random() % 17);
    CAPTURE(value);
    CAPTURE(digits);
    const double up = read_back(value, digits, Bound::upper);
    const double nearest = read_back(value, digits, Bound::none);
    CHECK(up >= value);
    // It is the nearest of so many digits where that is not below, and else the next.
    if (nearest >= value) CHECK(up == nearest);
    const double unit = std::pow(10.0, std::floor(std::log10(value)) + 1 - digits);
    CHECK(up - value <= unit * (1 + 1e-9) + 2e-16 * value);
    std::string text;
    proto::append_bound(text, value, digits, Bound::upper);
    const auto written = std::count_if(
        text.begin(),
        text.begin() + static_cast<std::ptrdiff_t>(std::min(text.find('e'), text.size())),
        [](char c) { return c >= '1' && c <= '9'; });
    CHECK(written <= digits);
  }
  std::string text;
  proto::append_bound(text, 0, 3, Bound::upper);
  proto::append_bound(text, std::numeric_limits<double>::infinity(), 3, Bound::upper);
  CHECK(text == "0null");
}

TEST_CASE("ABoundInFloatsAndInSmallWholeNumbersIsNotBelow") {
  std::mt19937_64 random(fixtures::test_seed());
  for (int round = 0; round < 200; ++round) {
    const double size = random_distance(random);
    std::vector<double> values;
    double max = 0;
    for (int i = 0; i < 200; ++i) {
      double value = size * static_cast<double>(random() >> 11U) * 0x1p-53;
      // On a step, or next to one.
      if (i % 4 == 0) value = std::nextafter(std::floor(value / size * 65534) * size / 65534, size);
      values.push_back(value);
      max = std::max(max, value);
    }
    values.push_back(std::numeric_limits<double>::infinity());
    CAPTURE(max);
    const auto floats = numbers<float>(proto::f32_bytes(values, Bound::upper));
    const auto steps = numbers<std::uint16_t>(proto::u16_bytes(values, max, Bound::upper));
    for (std::size_t i = 0; i + 1 < values.size(); ++i) {
      CAPTURE(values[i]);
      CHECK(static_cast<double>(floats[i]) >= values[i]);
      CHECK(floats[i] <= values[i] * (1 + 1.2e-7) + std::numeric_limits<float>::denorm_min());
      CHECK(steps[i] / 65534.0 * max >= values[i]);
      if (steps[i] < 65534) CHECK(steps[i] * (max / 65534) >= values[i]);
      CHECK(steps[i] / 65534.0 * max <= values[i] + max / 65534 * (1 + 1e-9));
    }
    CHECK(floats.back() == std::numeric_limits<float>::infinity());
    CHECK(steps.back() == 65535);
  }
}
