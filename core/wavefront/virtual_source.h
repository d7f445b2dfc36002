// The virtual start point of Tang, Wu, Zhang and Zhang, "Fast Approximate
// Geodesic Paths on Triangle Mesh", 2007, section 3.2.
//
// A triangle is unfolded into the plane over its base p -> q, with the third
// vertex w (the apex) above it. Two circles, around p and q with their distances
// as radii, meet in a point s below the base: the virtual source. Where the line
// from s to w meets the base's line decides among the three cases of the paper's
// Fig. 4.
//
// All plane coordinates here are multiplied by the base's length. That turns the
// paper's formulas into dot products and twice the area of the triangle, with no
// division and no square root until the distance itself.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/surface/unfolded_apex.h"

namespace geodesic {

enum class Fig4 : std::uint8_t {
  a,  // the straight line crosses the base
  b,  // it passes p outside the base: the path bends at p
  c,  // it passes q outside the base: the path bends at q
};

struct Arrival {
  double distance;  // of the apex
  Fig4 which;
  double crossing;  // where the line meets the base, 0 at p and 1 at q; in case (a) only
};

// The apex's distance, given those of the base's ends.
//
// The circles' intersection is found in a form that stays accurate when s is
// close to the base's line: with L the base's length,
//   s_x L   = (L^2 + (dp - dq)(dp + dq)) / 2
//   s_y^2 L^2 = ((dp + dq)^2 - L^2) (L^2 - (dp - dq)^2) / 4    (Heron)
// Circles that do not meet (dp and dq differ by more than L, which approximate
// distances may) put s on the base's line, and case (b) or (c) follows.
[[nodiscard]] inline Arrival arrive(double dp, double dq, const UnfoldedApex& w) {
  const double base2 = w.base2();
  const double sum = dp + dq;
  const double difference = dp - dq;
  const double sx = 0.5 * (base2 + difference * sum);
  const double sy2 = 0.25 * (sum * sum - base2) * (base2 - difference * difference);
  const double sy = std::sqrt(std::max(sy2, 0.0));

  const double rise = sy + w.height;
  const double meets = sx * w.height + w.from_p * sy;  // crossing * base2 * rise
  const bool no_base = !(base2 > 0);
  // No rise: source, base and apex on one line. The way leads over the base all the same.
  const bool on_line = !(rise > 0);
  if (meets < 0 || (no_base && dp <= dq) || (on_line && sx < 0 && w.from_p < 0)) {
    return {dp + std::sqrt(std::max(w.to_p2, 0.0)), Fig4::b, 0};
  }
  if (meets > base2 * rise || no_base || (on_line && sx > base2 && w.from_p > base2)) {
    return {dq + std::sqrt(std::max(w.to_q2, 0.0)), Fig4::c, 1};
  }
  const double run = w.from_p - sx;
  // On a line any point between will do.
  const double crossing = on_line ? std::clamp(sx / base2, 0.0, 1.0) : meets / (base2 * rise);
  return {std::sqrt((run * run + rise * rise) / base2), Fig4::a, crossing};
}

// The apex's distance when the base's ends hold distances from two different
// sources. Circles of two sources mean nothing together; what is certain is the
// way along either side of the triangle.
[[nodiscard]] inline Arrival arrive_along_sides(double dp, double dq, const UnfoldedApex& w) {
  const double by_p = dp + std::sqrt(std::max(w.to_p2, 0.0));
  const double by_q = dq + std::sqrt(std::max(w.to_q2, 0.0));
  return by_p <= by_q ? Arrival{by_p, Fig4::b, 0} : Arrival{by_q, Fig4::c, 1};
}

}  // namespace geodesic
