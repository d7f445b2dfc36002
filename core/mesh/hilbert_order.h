// The space-filling curve along which vertices are numbered.
#pragma once

#include <cstdint>

namespace geodesic {

inline constexpr unsigned kHilbertBits = 30;

// Position on the three-dimensional Hilbert curve of the cell (x, y, z) in a
// grid of 2^10 cells a side: kHilbertBits bits.
// After J. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707, 2004.
[[nodiscard]] inline std::uint32_t hilbert_index(std::uint32_t x, std::uint32_t y,
                                                 std::uint32_t z) {
  constexpr int kBits = 10;
  std::uint32_t axis[3] = {x, y, z};
  for (std::uint32_t q = 1U << (kBits - 1); q > 1; q >>= 1U) {
    const std::uint32_t low = q - 1;
    for (std::uint32_t& a : axis) {
      if ((a & q) != 0) {
        axis[0] ^= low;
      } else {
        const std::uint32_t swap = (axis[0] ^ a) & low;
        axis[0] ^= swap;
        a ^= swap;
      }
    }
  }
  axis[1] ^= axis[0];
  axis[2] ^= axis[1];
  std::uint32_t flip = 0;
  for (std::uint32_t q = 1U << (kBits - 1); q > 1; q >>= 1U) {
    if ((axis[2] & q) != 0) flip ^= q - 1;
  }
  std::uint32_t index = 0;
  for (int bit = kBits - 1; bit >= 0; --bit) {
    for (const std::uint32_t a : axis) index = (index << 1U) | (((a ^ flip) >> bit) & 1U);
  }
  return index;
}

}  // namespace geodesic
