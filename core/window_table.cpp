#include "core/window_table.h"

#include <algorithm>

namespace geodesic {

WindowTable::WindowTable(std::size_t face_count,
                         std::vector<std::pair<Halfedge, LitWindow>> windows) {
  std::sort(windows.begin(), windows.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second.begin < b.second.begin;
  });
  begin_.assign(4 * face_count + 1, 0);
  windows_.reserve(windows.size());
  for (const auto& [h, window] : windows) {
    ++begin_[h + 1];
    windows_.push_back(window);
  }
  for (std::size_t h = 0; h + 1 < begin_.size(); ++h) begin_[h + 1] += begin_[h];
}

std::size_t WindowTable::bytes() const {
  return sizeof(WindowTable) + begin_.capacity() * sizeof(std::uint64_t) +
         windows_.capacity() * sizeof(LitWindow);
}

}  // namespace geodesic
