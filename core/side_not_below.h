// The lengths of a face's sides, where rounding has left them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/face_record.h"

namespace geodesic {

[[nodiscard]] inline double longest_side(const FaceRecord& face) {
  return std::sqrt(std::max({face.length2(0), face.length2(1), face.length2(2), 0.0}));
}

// The length of the edge vertex[c] - vertex[c + 1]; never below it by more than 1e-10 of it. The
// dot products of a face are off by some roundings of its longest side's square, so that of a side
// 1e16 times shorter they leave nothing.
[[nodiscard]] inline double side_not_below(const FaceRecord& face, std::uint32_t c) {
  constexpr double kRoundings = 8 * std::numeric_limits<double>::epsilon();
  constexpr double kMostRatio2 = 1e8;  // up to there a rounding of the longest is no more than that
  const double length2 = std::max(face.length2(c), 0.0);
  const double longest = longest_side(face);
  if (longest * longest <= kMostRatio2 * length2) return std::sqrt(length2);
  return std::sqrt(length2) + (kRoundings + double{face.error}) * longest;
}

}  // namespace geodesic
