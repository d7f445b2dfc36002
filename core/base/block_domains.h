// Things that are numbered so that near ones have near numbers, divided among domains, each of
// which one thread at a time works on.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace geodesic {

// By blocks of numbers. Of larger blocks one domain has often more of a front than others, of
// smaller ones more is handed on.
class BlockDomains {
 public:
  BlockDomains() = default;  // all in one
  BlockDomains(std::size_t things, std::size_t domains) : count_(domains) {
    constexpr std::size_t kBlocksOfDomain = 16;
    constexpr int kMostBits = 11;
    const int width = std::bit_width(things / (kBlocksOfDomain * domains));
    bits_ = static_cast<unsigned>(std::clamp(width - 1, 0, kMostBits));
  }

  [[nodiscard]] std::size_t count() const { return count_; }

  [[nodiscard]] std::size_t of(std::uint32_t number) const {
    // As if at random, for numbers may have a period as a front has: Fibonacci hashing (Knuth,
    // The Art of Computer Programming 3, section 6.4).
    const std::uint32_t mixed = (number >> bits_) * 0x9e3779b9U;
    return static_cast<std::size_t>((std::uint64_t{mixed} * count_) >> 32U);
  }

 private:
  std::size_t count_ = 1;
  unsigned bits_ = 0;
};

}  // namespace geodesic
