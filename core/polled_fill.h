// Filling memory that is so large that it must be possible to stop halfway: the
// first touch of a hundred megabytes takes as long as thousands of steps.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/cancel.h"

namespace geodesic {

// As values.assign(count, value); shorter if the poll says to stop.
template <class T>
void polled_assign(std::vector<T>& values, std::size_t count, const T& value, Poll& poll) {
  constexpr std::size_t kAtOnce = (std::size_t{1} << 23U) / sizeof(T);  // 8 MiB, a few ms
  values.clear();
  values.reserve(count);
  while (values.size() < count && !poll.stopped()) {
    values.resize(std::min(count, values.size() + kAtOnce), value);
    if (values.size() < count) (void)poll.ask();
  }
}

}  // namespace geodesic
