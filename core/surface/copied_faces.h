// Faces with the same three corners: what passes through one passes through all of them.
#pragma once

#include <cstdint>

#include "core/surface/adjacency.h"

namespace geodesic {

// Whether a later face has the same corners. In an edge's ring faces with the same apex follow one
// another, in ascending order (Adjacency), so one look at the next one tells.
[[nodiscard]] inline bool has_later_copy(const Adjacency& adjacency, std::uint32_t f) {
  const Halfedge next = adjacency.ring(halfedge(f, 0));
  const std::uint32_t apex = adjacency.face(face_of(next)).vertex[previous_corner(corner_of(next))];
  return next > halfedge(f, 0) && apex == adjacency.face(f).vertex[previous_corner(0)];
}

// The next of the faces with the same corners; only if there is one.
[[nodiscard]] inline std::uint32_t later_copy(const Adjacency& adjacency, std::uint32_t f) {
  return face_of(adjacency.ring(halfedge(f, 0)));
}

}  // namespace geodesic
