// What rounding does to faces that are unfolded into a plane one after another, and what it may
// take from a straight way over them.
//
// A corner is off by some roundings of how far it is from the origin. As the end of an edge it
// turns and scales all that is unfolded beyond that edge, by so much over the edge's length. Both
// add up over the faces, they do not multiply: what is turned is turned as a whole.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/cancel.h"
#include "core/face_record.h"
#include "core/side_not_below.h"

namespace geodesic {

struct UnfoldRounding {
  // The longest way from the origin to what was unfolded, over the shortest side on the way: up
  // to there rounding turns nothing that a trace goes over by more than 2e-10.
  static constexpr double kMostSpread2 = 1e6;  // squared

  // Of what one step unfolds, a part of the farthest that was unfolded.
  static constexpr double kRoundings = 16 * std::numeric_limits<double>::epsilon();
  // Edges beyond which more may be turned say nothing any more. In radians, summed up.
  static constexpr double kMostTurn = 1e-9;
  // A way that rounding may have made too short by more than this part of it is told as longer
  // by as much.
  static constexpr double kHair = 1e-10;

  // How far a corner of a face may be off, when nothing is farther than `farthest`.
  [[nodiscard]] static double of_corner(const FaceRecord& face, double farthest) {
    const double flips = face.error > 0 ? double{face.error} * longest_side(face) : 0;
    return kRoundings * farthest + flips;
  }

  // What may be missing from a straight way to a corner that is off by `rounding`, `turn` being
  // that of the edge before it. All that is turned lies within twice the farthest; the way may
  // pass the bounds on their wrong side by as much, and is longer past their right side by twice
  // that.
  [[nodiscard]] static double lack(double straight, double farthest, double turn, double rounding) {
    const double most = 6 * farthest * turn + 4 * rounding;
    return most > kHair * straight ? most : 0;
  }
};

// How low a face is, of its sides: below the first of these what is computed across it may be less
// exact than its sides, and below the second it may be anything.
inline constexpr double kFlat = 1e-5;
inline constexpr double kWithoutArea = 1e-10;
[[nodiscard]] inline bool is_lower_than(double part, const FaceRecord& face) {
  return !(face.area2 > part * (face.dot[0] + face.dot[1] + face.dot[2]));
}

// Triangulation::is_even, for who makes one. False when the poll says to stop.
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
