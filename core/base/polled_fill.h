// Filling memory that is so large that it must be possible to stop halfway: the
// first touch of a hundred megabytes takes as long as thousands of steps. And so large that
// the budget is asked before.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/cancel.h"

namespace geodesic {

// As values.assign(count, value); shorter if the poll says to stop.
template <class T>
void polled_assign(std::vector<T>& values, std::size_t count, const T& value, Poll& poll) {
  constexpr std::size_t kAtOnce = (std::size_t{1} << 23U) / sizeof(T);  // 8 MiB, a few ms
  values.clear();
  if (count > values.capacity() && !poll.may_take(count * sizeof(T))) return;
  values.reserve(count);
  while (values.size() < count && !poll.stopped()) {
    values.resize(std::min(count, values.size() + kAtOnce), value);
    if (values.size() < count) (void)poll.ask();
  }
}

// As values.assign(from.begin(), from.end()); shorter if the poll says to stop.
template <class Values, class T>
void polled_copy(Values& values, std::span<const T> from, Poll& poll) {
  constexpr std::size_t kAtOnce = (std::size_t{1} << 23U) / sizeof(T);
  values.clear();
  if (from.size() > values.capacity() && !poll.may_take(from.size() * sizeof(T))) return;
  values.reserve(from.size());
  while (values.size() < from.size() && !poll.stopped()) {
    const auto rest = from.subspan(values.size());
    const auto next = rest.first(std::min(rest.size(), kAtOnce));
    values.insert(values.end(), next.begin(), next.end());
    if (values.size() < from.size()) (void)poll.ask();
  }
}

}  // namespace geodesic
