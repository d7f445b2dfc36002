#include "core/base/polled_sort.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <random>
#include <vector>

using namespace geodesic;

TEST_CASE("PolledSortSortsAsTheLibraryDoes") {
  std::mt19937 random(5);
  for (const std::size_t count : {0, 1, 2, 8191, 8192, 8193, 16384, 16385, 40000, 100001}) {
    for (const unsigned most : {3U, 1000U, 4000000000U}) {  // many equal ones, some, hardly any
      CAPTURE(count);
      CAPTURE(most);
      std::vector<unsigned> values(count + 7);
      for (unsigned& value : values) value = random() % most;
      std::vector<unsigned> sorted = values;
      // The first two and the last five are left alone.
      std::sort(sorted.begin() + 2, sorted.end() - 5, std::greater<>());
      const Cancel never;
      Poll poll(never);
      std::vector<unsigned> spare;
      polled_sort(values, 2, count + 2, std::greater<>(), spare, poll);
      CHECK(values == sorted);
    }
  }
}

TEST_CASE("PolledSortStopsWhenTold") {
  std::vector<unsigned> values(200'000);
  std::mt19937 random(5);
  for (unsigned& value : values) value = random();
  std::size_t asked = 0;
  for (const std::size_t at : {1, 10, 60, 200}) {
    CAPTURE(at);
    asked = 0;
    std::size_t compared = 0;
    std::vector<unsigned> spare;
    std::vector<unsigned> copy = values;
    const Cancel cancel([&] { return ++asked == at; });
    Poll poll(cancel);
    const auto before = [&](unsigned a, unsigned b) {
      ++compared;
      return a < b;
    };
    polled_sort(copy, 0, copy.size(), before, spare, poll);
    CHECK(poll.stopped());
    CHECK(asked == at);
    // A run of 8,192 takes some 20 comparisons an element.
    CHECK(compared <= at * 8192 * 20);
  }
}
