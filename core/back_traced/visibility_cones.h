// What sources see: the vertices that straight lines from them reach without a bend.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/tolerances.h"
#include "core/base/vec2.h"
#include "core/surface/face_record.h"
#include "core/surface/triangulation.h"
#include "core/surface/unfold_rounding.h"

namespace geodesic {

// A cone of straight lines from a source at the origin, out of a face over its edge.
struct VisibilityCone {
  std::uint32_t source;  // its number
  Halfedge edge;         // on the source's side
  std::uint32_t right;   // the vertex at its right end
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
[[nodiscard]] inline VisibilityCone cone_over(std::uint32_t source, const FaceRecord& face,
                                              Halfedge edge, std::uint32_t right, Vec2 to_right,
                                              Vec2 to_left) {
  const double farthest = std::max(norm(to_right), norm(to_left));
  const double turn = UnfoldRounding::of_corner(face, farthest) / norm(to_left - to_right);
  return {source, edge, right, to_right, to_left, to_right, to_left, turn, farthest};
}

// Tells `see(source, vertex, distance)` of every vertex that one of the cones comes to, and how far
// it is that way: each is the length of a path on the surface. The cones go on as if through a
// surface without an end, those that have crossed fewer faces first, until those of a source have
// crossed `most` of them (a cone that crosses none counts as one), and not beyond faces for no
// corner of which `goes_on(source, vertex, distance)` holds. `crossed`: a 0 for each source. Works
// in the vector it is given. Stops early when the poll says to stop, or has no memory left.
template <class GoesOn, class See>
void look_around(const Triangulation& surface, std::vector<VisibilityCone>& cones, std::size_t most,
                 std::span<std::size_t> crossed, Poll& poll, GoesOn goes_on, See see) {
  constexpr std::size_t kForgotten = 16'384;
  for (std::size_t i = 0; i < cones.size() && !poll.cancelled(); ++i) {
    if (i >= kForgotten && 2 * i >= cones.size()) {
      cones.erase(cones.begin(), cones.begin() + static_cast<std::ptrdiff_t>(i));
      i = 0;
    }
    // Those of several sources lie apart in memory.
    if (i + 16 < cones.size()) __builtin_prefetch(&surface.faces[face_of(cones[i + 16].edge)]);
    if (i + 8 < cones.size()) {
      __builtin_prefetch(&surface.faces[face_of(surface.ring(cones[i + 8].edge))]);
    }
    const VisibilityCone cone = cones[i];
    std::size_t& faces = crossed[cone.source];
    // Nor do they go on where nobody can say which way.
    if (faces >= most || !(cone.turn <= tolerance::kMostTurn)) continue;
    Halfedge across = surface.ring(cone.edge);
    if (across == cone.edge) ++faces;
    for (; across != cone.edge && faces < most; across = surface.ring(across), ++faces) {
      if (cones.size() + 2 > cones.capacity() && cones.size() > kForgotten &&
          !poll.may_take(2 * cones.size() * sizeof(VisibilityCone))) {
        return;
      }
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
      if (!goes_on(cone.source, face.vertex[apex], straight) &&
          !goes_on(cone.source, face.vertex[forward ? c : n], norm(cone.to_right)) &&
          !goes_on(cone.source, face.vertex[forward ? n : c], norm(cone.to_left))) {
        continue;
      }
      const double farthest = std::max(cone.farthest, straight);
      const double rounding = UnfoldRounding::of_corner(face, farthest);
      if (within_left && within_right) {
        see(cone.source, face.vertex[apex],
            straight + UnfoldRounding::lack(straight, farthest, cone.turn, rounding));
      }
      // To the right of the apex, and to the left of it.
      if (within_right) {
        cones.push_back({cone.source, halfedge(face_of(across), forward ? apex : n), cone.right,
                         cone.to_right, to_apex, cone.right_bound,
                         within_left ? to_apex : cone.left_bound,
                         cone.turn + rounding / norm(to_apex - cone.to_right), farthest});
      }
      if (within_left) {
        cones.push_back({cone.source, halfedge(face_of(across), forward ? n : apex),
                         face.vertex[apex], to_apex, cone.to_left,
                         within_right ? to_apex : cone.right_bound, cone.left_bound,
                         cone.turn + rounding / norm(cone.to_left - to_apex), farthest});
      }
    }
  }
}

}  // namespace geodesic
