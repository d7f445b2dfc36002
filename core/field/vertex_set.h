// Vertices that a front has come to, for what is to be done at these alone.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace geodesic {

class VertexSet {
 public:
  // None of so many.
  void reset(std::size_t vertex_count) {
    listed_.clear();
    words_.assign(vertex_count / kWord + 1, 0);
  }

  void insert(std::uint32_t v) {
    std::uint64_t& word = words_[v / kWord];
    const std::uint64_t bit = std::uint64_t{1} << (v % kWord);
    if ((word & bit) != 0) return;
    word |= bit;
    listed_.push_back(v);
  }

  // Each once, in the order in which they came. Valid until the next one comes.
  [[nodiscard]] std::span<const std::uint32_t> listed() const { return listed_; }

  // Calls `tell(v)` for each, ascending, for what is near in number is near in memory. What `tell`
  // inserts is told, too, if it is in a later word.
  template <class Tell>
  void for_each_ascending(Tell tell) const {
    for (std::uint32_t word = 0; word < words_.size(); ++word) {
      for (std::uint64_t left = words_[word]; left != 0; left &= left - 1) {
        tell(kWord * word + static_cast<std::uint32_t>(std::countr_zero(left)));
      }
    }
  }

 private:
  static constexpr std::uint32_t kWord = 64;

  std::vector<std::uint64_t> words_;  // a bit a vertex
  std::vector<std::uint32_t> listed_;
};

}  // namespace geodesic
