#include "core/base/sort_few.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

using namespace geodesic;

TEST_CASE("SortFewSortsAsTheLibraryDoes") {
  std::mt19937 random(3);
  for (std::uint32_t count = 0; count < 300; ++count) {
    CAPTURE(count);
    // Far apart and close together, the greatest vertex there can be among them.
    for (const std::uint32_t step : {1U, 7'000'000U}) {
      std::vector<std::uint32_t> values(count);
      for (std::uint32_t i = 0; i < count; ++i) values[i] = (1U << 31U) - 1 - i * step;
      const std::vector<std::uint32_t> sorted(values.rbegin(), values.rend());
      std::shuffle(values.begin(), values.end(), random);
      sort_few(values);
      CHECK(values == sorted);
    }
  }
}
