// What a source sees: the vertices that straight lines from it reach without a bend.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/tolerances.h"
#include "core/base/vec2.h"
#include "core/surface/face_record.h"
#include "core/surface/triangulation.h"
#include "core/surface/unfold_rounding.h"

namespace geodesic {

// A cone of straight lines from a source at the origin, out of a face over its edge.
struct VisibilityCone {
  Halfedge edge;        // on the source's side
  std::uint32_t right;  // the vertex at its right end
  Vec2 to_right;
  Vec2 to_left;
  Vec2 right_bound;
  Vec2 left_bound;
  // How far what is beyond the edge may be turned by rounding (unfold_rounding.h), and how far
  // away the farthest was.
  double turn = 0;
  double farthest = 0;
};

// A cone out of a face over that edge of it, all that can be seen of it.
[[nodiscard]] inline VisibilityCone cone_over(const FaceRecord& face, Halfedge edge,
                                              std::uint32_t right, Vec2 to_right, Vec2 to_left) {
  const double farthest = std::max(norm(to_right), norm(to_left));
  const double turn = UnfoldRounding::of_corner(face, farthest) / norm(to_left - to_right);
  return {edge, right, to_right, to_left, to_right, to_left, turn, farthest};
}

// Tells `see` of every vertex that one of the cones comes to, and how far it is that
// way: each is the length of a path on the surface. The cones go on as if through a
// surface without an end, those that have crossed fewer faces first, until they have crossed
// `most` of them (a cone that crosses none counts as one), and not beyond faces for no corner of
// which `goes_on(vertex, distance)` holds. Works in the vector it is given, to which no more than
// two cones for each of those come.
template <class GoesOn, class See>
void look_around(const Triangulation& surface, std::vector<VisibilityCone>& cones, std::size_t most,
                 GoesOn goes_on, See see) {
  std::size_t crossed = 0;
  for (std::size_t i = 0; i < cones.size() && crossed < most; ++i) {
    const VisibilityCone cone = cones[i];
    // Nor do they go on where nobody can say which way.
    if (!(cone.turn <= tolerance::kMostTurn)) continue;
    Halfedge across = surface.ring(cone.edge);
    if (across == cone.edge) ++crossed;
    for (; across != cone.edge && crossed < most; across = surface.ring(across), ++crossed) {
      const FaceRecord& face = surface.faces[face_of(across)];
      const std::uint32_t c = corner_of(across);
      const std::uint32_t n = next_corner(c);
      const std::uint32_t apex = previous_corner(c);
      const bool forward = face.vertex[c] == cone.right;
      const double base2 = face.dot[c] + face.dot[n];
      if (!(base2 > 0) || is_seen_along_line(face, cone.to_right, cone.to_left)) continue;
      const Vec2 base = cone.to_left - cone.to_right;
      const Vec2 to_apex = cone.to_right + ((forward ? face.dot[c] : face.dot[n]) / base2) * base +
                           (face.area2 / base2) * Vec2{base.y, -base.x};
      const bool within_left = cross(to_apex, cone.left_bound) >= 0;
      const bool within_right = cross(cone.right_bound, to_apex) >= 0;
      const double straight = norm(to_apex);
      if (!goes_on(face.vertex[apex], straight) &&
          !goes_on(face.vertex[forward ? c : n], norm(cone.to_right)) &&
          !goes_on(face.vertex[forward ? n : c], norm(cone.to_left))) {
        continue;
      }
      const double farthest = std::max(cone.farthest, straight);
      const double rounding = UnfoldRounding::of_corner(face, farthest);
      if (within_left && within_right) {
        see(face.vertex[apex],
            straight + UnfoldRounding::lack(straight, farthest, cone.turn, rounding));
      }
      // To the right of the apex, and to the left of it.
      if (within_right) {
        cones.push_back({halfedge(face_of(across), forward ? apex : n), cone.right, cone.to_right,
                         to_apex, cone.right_bound, within_left ? to_apex : cone.left_bound,
                         cone.turn + rounding / norm(to_apex - cone.to_right), farthest});
      }
      if (within_left) {
        cones.push_back({halfedge(face_of(across), forward ? n : apex), face.vertex[apex], to_apex,
                         cone.to_left, within_right ? to_apex : cone.right_bound, cone.left_bound,
                         cone.turn + rounding / norm(cone.to_left - to_apex), farthest});
      }
    }
  }
}

}  // namespace geodesic
