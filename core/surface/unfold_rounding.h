// What rounding does to the sides of a face, and to faces that are unfolded into a plane one after
// another: by how much it may shorten a straight way over them.
//
// A corner is off by a few roundings of its distance from the origin. As the end of an edge, it
// turns and scales everything that is unfolded beyond that edge, by its error over the edge's
// length. These errors add up over the faces. They do not multiply, because everything beyond an
// edge is turned as a whole.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/team.h"
#include "core/base/tolerances.h"
#include "core/base/vec2.h"
#include "core/surface/face_record.h"

namespace geodesic {

[[nodiscard]] inline double longest_side(const FaceRecord& face) {
  return std::sqrt(std::max(face.longest2(), 0.0));
}

// The length of the edge vertex[c] - vertex[c + 1], never below it by more than 1e-10 of it. On a
// mesh's own faces the two dot products at the edge are off by some roundings of its length times
// the longest side's. So they leave nothing of an edge 1e16 times shorter than the longest side.
[[nodiscard]] inline double side_not_below(const FaceRecord& face, std::uint32_t c) {
  constexpr double kMostRatio2 = 1e8;  // up to this ratio, rounding is below 1e-10 of the side
  const double length2 = std::max(face.length2(c), 0.0);
  const double longest = longest_side(face);
  if (longest * longest <= kMostRatio2 * length2) return std::sqrt(length2);
  return std::sqrt(length2) + (tolerance::kSide + double{face.error}) * longest;
}

struct UnfoldRounding {
  // How far a corner of a face may be off, when nothing is farther than `farthest`.
  [[nodiscard]] static double of_corner(const FaceRecord& face, double farthest) {
    const double flips = face.error > 0 ? double{face.error} * longest_side(face) : 0;
    return tolerance::kUnfolding * farthest + flips;
  }

  // How much too short a straight way to a corner may be; 0 if that is at most
  // tolerance::kLeastLack of the way. The corner is off by `rounding`, and the edge before it may
  // be turned by `turn`. Everything that is turned lies within twice the farthest. So the way may
  // pass a bound on the wrong side by as much as that moves it, and past the right side it is
  // longer by twice that.
  [[nodiscard]] static double lack(double straight, double farthest, double turn, double rounding) {
    const double most = 6 * farthest * turn + 4 * rounding;
    return most > tolerance::kLeastLack * straight ? most : 0;
  }
};

[[nodiscard]] inline bool is_lower_than(double part, const FaceRecord& face) {
  return !(face.area2 > part * (face.dot[0] + face.dot[1] + face.dot[2]));
}

// Whether the corners lie on one line, as far as rounding can tell, in three places.
[[nodiscard]] inline bool is_line(const FaceRecord& face) {
  const double shortest2 = face.shortest2();
  return shortest2 > 0 &&
         !(face.area2 > tolerance::kLine * std::sqrt(shortest2) * std::sqrt(face.longest2()));
}

// Whether what is seen over a face, through the edge from `right` to `left`, may be behind who
// looks from the origin, or before that edge: where they are on the same line, all directions are
// one.
[[nodiscard]] inline bool is_seen_along_line(const FaceRecord& face, Vec2 right, Vec2 left) {
  return is_line(face) &&
         !(cross(right, left) > tolerance::kWithoutArea * (dot(right, right) + dot(left, left)));
}

// Squares of the sides of many faces.
struct SideExtent {
  double longest2 = 0;
  double shortest2 = std::numeric_limits<double>::infinity();

  // What Triangulation::is_even says.
  [[nodiscard]] bool is_even() const { return longest2 <= tolerance::kMostSpread2 * shortest2; }
};

// With whoever helps. Of no use if the poll says to stop.
[[nodiscard]] inline SideExtent extent_of_sides(std::span<const FaceRecord> faces, Poll& poll) {
  std::vector<SideExtent> extents(count_blocks(faces.size()));
  run_in_blocks(faces.size(), poll,
                [&](std::size_t block, std::size_t begin, std::size_t end, Poll& asked) {
                  SideExtent extent;
                  for (const FaceRecord& face : faces.subspan(begin, end - begin)) {
                    if (asked.cancelled()) return;
                    const double a = face.length2(0);
                    const double b = face.length2(1);
                    const double c = face.length2(2);
                    extent.longest2 = std::max({extent.longest2, a, b, c});
                    extent.shortest2 = std::min({extent.shortest2, a, b, c});
                  }
                  extents[block] = extent;
                });
  SideExtent all;
  for (const SideExtent& extent : extents) {
    all.longest2 = std::max(all.longest2, extent.longest2);
    all.shortest2 = std::min(all.shortest2, extent.shortest2);
  }
  return all;
}

}  // namespace geodesic
