// An edge by its two vertices.
#pragma once

#include <algorithm>
#include <cstdint>

namespace geodesic {

// One number for the edge between two vertices, whichever comes first.
[[nodiscard]] inline std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::min(a, b)} << 32U | std::max(a, b);
}

}  // namespace geodesic
