// A face as every method walks on it: its vertices, its neighbours, and its shape
// unfolded into a plane. One face is one cache line.
//
// Halfedges and corners share one numbering, 4 * face + c with c in 0, 1, 2:
//   corner   4f + c: the corner of face f at vertex[c];
//   halfedge 4f + c: the edge of face f from vertex[c] to vertex[c + 1], with
//                    vertex[c + 2] opposite it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/tolerances.h"
#include "core/surface/unfolded_apex.h"

namespace geodesic {

using Halfedge = std::uint32_t;

[[nodiscard]] constexpr std::uint32_t face_of(Halfedge h) { return h >> 2U; }
[[nodiscard]] constexpr std::uint32_t corner_of(Halfedge h) { return h & 3U; }
[[nodiscard]] constexpr Halfedge halfedge(std::uint32_t face, std::uint32_t corner) {
  return 4 * face + corner;
}
// Without a branch: which way a search turns is anybody's guess.
[[nodiscard]] constexpr std::uint32_t next_corner(std::uint32_t c) { return (1U << c) & 3U; }
[[nodiscard]] constexpr std::uint32_t previous_corner(std::uint32_t c) {
  return (0x12U >> (2 * c)) & 3U;
}

struct alignas(64) FaceRecord {
  std::array<std::uint32_t, 3> vertex;
  std::array<Halfedge, 3> ring;  // the next halfedge on the same edge, cyclic
  std::array<double, 3> dot;     // at each corner, the dot product of the two edges leaving it
  double area2;                  // twice the area
  // How far a corner may be from its place, laid out with the others, of the longest side:
  // what flips of edges have lost (intrinsic_delaunay.h). None on a mesh's own faces.
  float error = 0;
  std::uint32_t unused = 0;  // padding, so that records are written without indeterminate bytes

  // Squared length of the edge vertex[c] - vertex[c + 1].
  [[nodiscard]] double length2(std::uint32_t c) const { return dot[c] + dot[next_corner(c)]; }
  [[nodiscard]] double longest2() const { return std::max({length2(0), length2(1), length2(2)}); }
  [[nodiscard]] double shortest2() const { return std::min({length2(0), length2(1), length2(2)}); }
  // Whether length2 says little: of an edge far shorter than the others the two products are
  // nearly opposite, and their sum is what rounding leaves of them, if not zero.
  [[nodiscard]] bool loses_length(std::uint32_t c) const {
    return is_length_below(c, tolerance::kHalfOfDigits);
  }
  // The same where it has to be right to almost all digits.
  [[nodiscard]] bool loses_digits_of_length(std::uint32_t c) const {
    return is_length_below(c, tolerance::kFewDigits);
  }
  // The corner that the longest edge begins at, so that the edge is c - next_corner(c).
  [[nodiscard]] std::uint32_t longest_side() const {
    const std::uint32_t c = length2(1) > length2(0) ? 1 : 0;
    return length2(2) > length2(c) ? 2 : c;
  }
  // The vertex opposite the base vertex[c] -> vertex[c + 1], unfolded over it.
  [[nodiscard]] UnfoldedApex apex_over(std::uint32_t c) const {
    const double p = dot[c];
    const double q = dot[next_corner(c)];
    const double w = dot[previous_corner(c)];
    return {p, q, area2, p + w, q + w};
  }

 private:
  [[nodiscard]] bool is_length_below(std::uint32_t c, double part) const {
    const double product = std::max(std::abs(dot[c]), std::abs(dot[next_corner(c)]));
    return !(length2(c) > part * product);
  }
};

}  // namespace geodesic
