#include "core/field/window_table.h"

#include <algorithm>
#include <new>
#include <span>

#include "core/base/polled_fill.h"
#include "core/base/polled_sort.h"

namespace geodesic {

WindowTable::WindowTable(std::size_t face_count, VisibleIntervals windows, Poll& poll) {
  if (windows.size() > kMostWindows) throw std::bad_alloc();
  polled_assign(parts_, 4 * face_count, Part{}, poll);
  windows_ = LargeArray<VisibleInterval>(windows.size(), poll);
  if (poll.stopped()) return;
  windows.for_each([&](const VisibleIntervals::Entry& entry) {
    ++parts_[entry.first].count;
    return !poll.cancelled();
  });
  // First where those of each halfedge end. Filled in backwards, that becomes where
  // they begin, and they keep their order.
  std::uint32_t end = 0;
  for (Part& part : parts_) {
    if (poll.cancelled()) return;
    part.begin = end += part.count;
  }
  windows.take_backwards([&](const VisibleIntervals::Entry& entry) {
    windows_[--parts_[entry.first].begin] = entry.second;
    return !poll.cancelled();
  });
  std::vector<VisibleInterval> spare;
  std::span<VisibleInterval> all = windows_.all();
  for (const auto& [begin, count] : parts_) {
    if (poll.cancelled_after(1 + count / kWindowsAStep)) return;
    polled_sort(
        all, begin, std::size_t{begin} + count,
        [](const VisibleInterval& a, const VisibleInterval& b) { return a.begin < b.begin; }, spare,
        poll);
  }
}

std::size_t WindowTable::bytes() const {
  return sizeof(WindowTable) + parts_.capacity() * sizeof(Part) +
         windows_.size() * sizeof(VisibleInterval);
}

}  // namespace geodesic
