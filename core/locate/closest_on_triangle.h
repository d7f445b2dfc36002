// Where on a triangle the point that is closest to a point in space can be: inside, or on a side.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/base/vec3.h"
#include "core/surface/face_record.h"

namespace geodesic {

using TriangleWeights = std::array<double, 3>;

// The barycentric coordinates of the foot of the perpendicular from p, if the foot is inside of the
// triangle; they add up to 1 up to rounding. Otherwise the closest point is on a side.
//
// In the frame of the longest side, where a place along that side is as good as the coordinates
// are, however low the triangle is. By the areas of parts, a triangle that is a line has its foot
// anywhere on it: all areas are rounding.
[[nodiscard]] inline std::optional<TriangleWeights> foot_inside(Vec3 p,
                                                                const std::array<Vec3, 3>& corner) {
  std::uint32_t base = 0;
  double base2 = 0;  // the longest side, squared
  for (std::uint32_t c = 0; c < 3; ++c) {
    const Vec3 side = corner[next_corner(c)] - corner[c];
    const double side2 = dot(side, side);
    if (side2 > base2) {
      base = c;
      base2 = side2;
    }
  }
  if (!(base2 > 0)) return std::nullopt;
  const Vec3 along = corner[next_corner(base)] - corner[base];
  const Vec3 to_apex = corner[previous_corner(base)] - corner[base];
  const Vec3 to_p = p - corner[base];
  const double apex_along = dot(to_apex, along) / base2;
  const Vec3 up = to_apex - apex_along * along;
  const double height2 = dot(up, up);
  if (!(height2 > 0)) return std::nullopt;
  const double p_along = dot(to_p, along) / base2;
  const double of_apex = dot(to_p - p_along * along, up) / height2;
  const double of_head = p_along - of_apex * apex_along;
  TriangleWeights bary;
  bary[base] = 1 - of_apex - of_head;
  bary[next_corner(base)] = of_head;
  bary[previous_corner(base)] = of_apex;
  for (const double weight : bary) {
    if (!(weight > 0)) return std::nullopt;
  }
  return bary;
}

}  // namespace geodesic
