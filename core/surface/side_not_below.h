// The lengths of a face's sides, with an allowance for rounding.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/tolerances.h"
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

}  // namespace geodesic
