// The longest edge of a surface: how far beyond a bound a field has to go, so that
// what is within the bound is whole. From one vertex of a face to another it is no
// farther than that.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/surface/adjacency.h"

namespace geodesic {

// Mesh units.
[[nodiscard]] inline double longest_edge(const Adjacency& adjacency) {
  return std::sqrt(adjacency.triangulation().longest2);
}

// The same of some faces. O(f) for f of them.
[[nodiscard]] inline double longest_edge_of(const Adjacency& adjacency,
                                            std::span<const std::uint32_t> faces) {
  double longest2 = 0;
  for (const std::uint32_t f : faces) {
    const FaceRecord& face = adjacency.face(f);
    for (std::uint32_t c = 0; c < 3; ++c) longest2 = std::max(longest2, face.length2(c));
  }
  return std::sqrt(longest2);
}

}  // namespace geodesic
