// What rounding does to faces that are unfolded into a plane one after another, and by how much it
// may shorten a straight way over them.
//
// A corner is off by a few roundings of its distance from the origin. As the end of an edge, it
// turns and scales everything that is unfolded beyond that edge, by its error over the edge's
// length. These errors add up over the faces. They do not multiply, because everything beyond an
// edge is turned as a whole.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/base/cancel.h"
#include "core/surface/face_record.h"
#include "core/surface/side_not_below.h"

namespace geodesic {

struct UnfoldRounding {
  // The ratio of the greatest distance from the origin that was unfolded to the shortest side on
  // the way. Up to this ratio, rounding turns nothing that a trace goes over by more than 2e-10.
  static constexpr double kMostSpread2 = 1e6;  // squared

  // The error of the corner that one step unfolds, over the greatest distance unfolded so far.
  static constexpr double kRoundings = 16 * std::numeric_limits<double>::epsilon();
  // In radians, summed over the faces. Beyond an edge that may be turned by more than this, the
  // unfolding says nothing any more.
  static constexpr double kMostTurn = 1e-9;
  // If rounding may have shortened a way by more than this fraction of it, as much is added to the
  // way.
  static constexpr double kHair = 1e-10;

  // How far a corner of a face may be off, when nothing is farther than `farthest`.
  [[nodiscard]] static double of_corner(const FaceRecord& face, double farthest) {
    const double flips = face.error > 0 ? double{face.error} * longest_side(face) : 0;
    return kRoundings * farthest + flips;
  }

  // How much too short a straight way to a corner may be; 0 if that is at most kHair of the way.
  // The corner is off by `rounding`, and the edge before it may be turned by `turn`. Everything
  // that is turned lies within twice the farthest. So the way may pass a bound on the wrong side
  // by as much as that moves it, and past the right side it is longer by twice that.
  [[nodiscard]] static double lack(double straight, double farthest, double turn, double rounding) {
    const double most = 6 * farthest * turn + 4 * rounding;
    return most > kHair * straight ? most : 0;
  }
};

// Bounds on twice a face's area over half the sum of its squared sides. Below kFlat, the way along
// its sides may be shorter than what is computed across it: by a rule that waits until two corners
// have their distance, or by rounding. Below kWithoutArea, what is computed may be anything.
inline constexpr double kFlat = 1e-3;
inline constexpr double kWithoutArea = 1e-10;
[[nodiscard]] inline bool is_lower_than(double part, const FaceRecord& face) {
  return !(face.area2 > part * (face.dot[0] + face.dot[1] + face.dot[2]));
}

// Computes Triangulation::is_even. False when the poll says to stop.
[[nodiscard]] inline bool is_even(std::span<const FaceRecord> faces, Poll& poll) {
  double longest2 = 0;
  double shortest2 = std::numeric_limits<double>::infinity();
  for (const FaceRecord& face : faces) {
    if (poll.cancelled()) return false;
    const double a = face.length2(0);
    const double b = face.length2(1);
    const double c = face.length2(2);
    longest2 = std::max({longest2, a, b, c});
    shortest2 = std::min({shortest2, a, b, c});
  }
  return longest2 <= UnfoldRounding::kMostSpread2 * shortest2;
}

}  // namespace geodesic
