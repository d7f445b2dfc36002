// What a source sees: the vertices that straight lines from it reach without a bend.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/face_record.h"
#include "core/triangulation.h"
#include "core/vec2.h"

namespace geodesic {

// A wedge of straight lines from a source at the origin, out of a face over its edge.
struct Wedge {
  Halfedge edge;        // on the source's side
  std::uint32_t right;  // the vertex at its right end
  Vec2 to_right;
  Vec2 to_left;
  Vec2 right_bound;
  Vec2 left_bound;
};

// Tells `see` of every vertex that one of the wedges comes to, and how far it is that
// way: each is the length of a path on the surface. The wedges go on as if through a
// surface without an end, those that have crossed fewer faces first, until `most` of
// them have. Works in the vector it is given.
template <class See>
void look_around(const Triangulation& surface, std::vector<Wedge>& wedges, std::size_t most,
                 See see) {
  for (std::size_t i = 0; i < wedges.size() && i < most; ++i) {
    const Wedge wedge = wedges[i];
    for (Halfedge across = surface.ring(wedge.edge); across != wedge.edge;
         across = surface.ring(across)) {
      const FaceRecord& face = surface.faces[face_of(across)];
      const std::uint32_t c = corner_of(across);
      const std::uint32_t n = next_corner(c);
      const std::uint32_t apex = previous_corner(c);
      const bool forward = face.vertex[c] == wedge.right;
      const double base2 = face.dot[c] + face.dot[n];
      if (!(base2 > 0)) continue;
      const Vec2 base = wedge.to_left - wedge.to_right;
      const Vec2 to_apex = wedge.to_right + ((forward ? face.dot[c] : face.dot[n]) / base2) * base +
                           (face.area2 / base2) * Vec2{base.y, -base.x};
      const bool within_left = cross(to_apex, wedge.left_bound) >= 0;
      const bool within_right = cross(wedge.right_bound, to_apex) >= 0;
      if (within_left && within_right) see(face.vertex[apex], norm(to_apex));
      // To the right of the apex, and to the left of it.
      if (within_right) {
        wedges.push_back({halfedge(face_of(across), forward ? apex : n), wedge.right,
                          wedge.to_right, to_apex, wedge.right_bound,
                          within_left ? to_apex : wedge.left_bound});
      }
      if (within_left) {
        wedges.push_back({halfedge(face_of(across), forward ? n : apex), face.vertex[apex], to_apex,
                          wedge.to_left, within_right ? to_apex : wedge.right_bound,
                          wedge.left_bound});
      }
    }
  }
}

}  // namespace geodesic
