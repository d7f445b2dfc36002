// A triangle unfolded into the plane over one of its edges, the base p -> q, with its
// third vertex w (the apex) above it.
//
// All plane coordinates are multiplied by the base's length: then they are dot products
// and twice the area of the triangle, with no division and no square root.
#pragma once

namespace geodesic {

// A point w above the base p -> q. Units: squared lengths.
struct UnfoldedApex {
  double from_p;  // (w - p) . (q - p): its place along the base, times the base's length
  double from_q;  // (w - q) . (p - q): the same from the other end
  double height;  // its height over the base, times the base's length; not negative
  double to_p2;   // |w - p|^2
  double to_q2;   // |w - q|^2

  // Squared length of the base: the two feet add up to it. Not positive when the
  // base is shorter than rounding can tell from nothing.
  [[nodiscard]] double base2() const { return from_p + from_q; }
};

}  // namespace geodesic
