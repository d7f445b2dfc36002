// Sorting so much that it must be possible to stop halfway.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/base/cancel.h"

namespace geodesic {

// As std::sort(values.begin() + begin, values.begin() + end, before) on a vector or a span of T,
// and in no more than n log n steps whatever the values; in no order if the poll says to stop.
// Runs that a core sorts in a millisecond are sorted by the library, then merged in
// pairs through `spare`, which grows as needed.
template <class Values, class T, class Before>
void polled_sort(Values& values, std::size_t begin, std::size_t end, Before before,
                 std::vector<T>& spare, Poll& poll) {
  constexpr std::size_t kRun = 8192;
  const std::size_t count = end - begin;
  T* from = values.data() + begin;
  for (std::size_t run = 0; run < count; run += kRun) {
    std::sort(from + run, from + std::min(count, run + kRun), before);
    if (count > kRun && poll.ask()) return;
  }
  if (count <= kRun) return;
  if (count > spare.capacity() && !poll.may_take(count * sizeof(T))) return;
  if (spare.size() < count) spare.resize(count);
  T* to = spare.data();
  for (std::size_t width = kRun; width < count; width *= 2) {
    for (std::size_t run = 0; run < count; run += 2 * width) {
      std::size_t left = run;
      const std::size_t left_end = std::min(count, run + width);
      std::size_t right = left_end;
      const std::size_t right_end = std::min(count, run + 2 * width);
      for (std::size_t k = run; k < right_end; ++k) {
        if (poll.cancelled()) return;
        const bool take_right =
            right < right_end && (left == left_end || before(from[right], from[left]));
        to[k] = take_right ? from[right++] : from[left++];
      }
    }
    std::swap(from, to);
  }
  if (from == spare.data()) {
    std::copy(from, from + count, values.data() + begin);
  }
}

}  // namespace geodesic
