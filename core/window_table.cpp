#include "core/window_table.h"

#include <algorithm>

namespace geodesic {

WindowTable::WindowTable(std::size_t face_count,
                         std::vector<std::pair<Halfedge, LitWindow>> windows) {
  begin_.assign(4 * face_count + 1, 0);
  for (const auto& [h, window] : windows) ++begin_[h + 1];
  for (std::size_t h = 0; h + 1 < begin_.size(); ++h) begin_[h + 1] += begin_[h];
  windows_.resize(windows.size());
  std::vector<std::uint64_t> next(begin_.begin(), begin_.end() - 1);
  for (const auto& [h, window] : windows) windows_[next[h]++] = window;
  for (std::size_t h = 0; h + 1 < begin_.size(); ++h) {
    std::sort(windows_.begin() + static_cast<std::ptrdiff_t>(begin_[h]),
              windows_.begin() + static_cast<std::ptrdiff_t>(begin_[h + 1]),
              [](const LitWindow& a, const LitWindow& b) { return a.begin < b.begin; });
  }
}

std::size_t WindowTable::bytes() const {
  return sizeof(WindowTable) + begin_.capacity() * sizeof(std::uint64_t) +
         windows_.capacity() * sizeof(LitWindow);
}

}  // namespace geodesic
