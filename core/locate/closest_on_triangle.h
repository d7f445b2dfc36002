// Where on a triangle the point that is closest to a point in space can be: inside, or on a side.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "core/base/vec3.h"
#include "core/surface/face_record.h"

namespace geodesic {

using TriangleWeights = std::array<double, 3>;

// The place of the point of the segment a-b that is closest to p: 0 at a, 1 at b.
[[nodiscard]] inline double foot_on_segment(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 ab = b - a;
  const double length2 = dot(ab, ab);
  return length2 > 0 ? std::clamp(dot(p - a, ab) / length2, 0.0, 1.0) : 0.0;
}

// The barycentric coordinates of the foot of the perpendicular from p, if the foot is inside of the
// triangle; they add up to 1 up to rounding. Otherwise the closest point is on a side. `normal` is
// the cross product of two sides.
[[nodiscard]] inline std::optional<TriangleWeights> foot_inside(Vec3 p,
                                                                const std::array<Vec3, 3>& corner,
                                                                Vec3 normal) {
  const double normal2 = dot(normal, normal);
  if (!(normal2 > 0)) return std::nullopt;
  TriangleWeights bary;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const Vec3 a = corner[next_corner(c)];
    const Vec3 b = corner[previous_corner(c)];
    bary[c] = dot(normal, cross(b - a, p - a)) / normal2;
    if (!(bary[c] > 0)) return std::nullopt;
  }
  return bary;
}

}  // namespace geodesic
