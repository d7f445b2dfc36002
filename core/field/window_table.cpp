#include "core/field/window_table.h"

#include <algorithm>

#include "core/base/polled_fill.h"

namespace geodesic {

WindowTable::WindowTable(std::size_t face_count, VisibleIntervals windows, Poll& poll) {
  const std::size_t count = windows.size();
  polled_assign(begin_, 4 * face_count + 1, std::uint64_t{0}, poll);
  polled_assign(windows_, count, VisibleInterval{}, poll);
  if (poll.stopped()) return;
  // First where those of each halfedge end. Filled in backwards, that becomes where
  // they begin, and they keep their order.
  windows.for_each([&](const VisibleIntervals::Entry& entry) {
    ++begin_[entry.first];
    return !poll.cancelled();
  });
  for (std::size_t h = 1; h < begin_.size() && !poll.cancelled(); ++h) begin_[h] += begin_[h - 1];
  if (poll.stopped()) return;
  windows.take_backwards([&](const VisibleIntervals::Entry& entry) {
    windows_[--begin_[entry.first]] = entry.second;
    return !poll.cancelled();
  });
  for (std::size_t h = 0; h + 1 < begin_.size() && !poll.cancelled(); ++h) {
    std::sort(windows_.begin() + static_cast<std::ptrdiff_t>(begin_[h]),
              windows_.begin() + static_cast<std::ptrdiff_t>(begin_[h + 1]),
              [](const VisibleInterval& a, const VisibleInterval& b) { return a.begin < b.begin; });
  }
}

std::size_t WindowTable::bytes() const {
  return sizeof(WindowTable) + begin_.capacity() * sizeof(std::uint64_t) +
         windows_.capacity() * sizeof(VisibleInterval);
}

}  // namespace geodesic
