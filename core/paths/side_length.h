// The length of a face's side, also where rounding has lost it in the face's record.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/base/vec3.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// The squared length of the side that starts at corner c. Of a side far shorter than the others the
// record's dot products leave only rounding; its length comes from the positions.
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
