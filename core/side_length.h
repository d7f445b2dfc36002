// The length of a face's side where its record has lost it.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/adjacency.h"
#include "core/vec3.h"

namespace geodesic {

// Squared, of the side that starts at corner c: from the positions where the products of the
// record leave nothing but rounding, as they do of a side far shorter than the others.
[[nodiscard]] inline double side_length2(const Adjacency& adjacency, std::uint32_t f,
                                         std::uint32_t c) {
  const FaceRecord& face = adjacency.face(f);
  if (!face.loses_length(c)) [[likely]]
    return std::max(face.length2(c), 0.0);
  const auto positions = adjacency.mesh().positions();
  const Vec3 side = positions[face.vertex[next_corner(c)]] - positions[face.vertex[c]];
  return dot(side, side);
}

}  // namespace geodesic
