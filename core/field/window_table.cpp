#include "core/field/window_table.h"

#include <algorithm>

#include "core/base/polled_fill.h"
#include "core/base/polled_sort.h"

namespace geodesic {
namespace {

// So many sorted in a list are a step to the poll: a thousand steps take a millisecond or two.
constexpr std::size_t kWindowsAStep = 16;

}  // namespace

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
  std::vector<VisibleInterval> spare;
  for (std::size_t h = 0; h + 1 < begin_.size(); ++h) {
    if (poll.cancelled_after(1 + (begin_[h + 1] - begin_[h]) / kWindowsAStep)) return;
    polled_sort(
        windows_, begin_[h], begin_[h + 1],
        [](const VisibleInterval& a, const VisibleInterval& b) { return a.begin < b.begin; }, spare,
        poll);
  }
}

std::size_t WindowTable::bytes() const {
  return sizeof(WindowTable) + begin_.capacity() * sizeof(std::uint64_t) +
         windows_.capacity() * sizeof(VisibleInterval);
}

}  // namespace geodesic
