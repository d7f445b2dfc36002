// Where a ray is within a box.
#pragma once

#include <algorithm>
#include <limits>

#include "core/base/vec3.h"
#include "core/mesh/mesh.h"

namespace geodesic {

// From origin + begin * direction to origin + end * direction.
struct RaySpan {
  double begin;
  double end;
};

// The part of a ray, carried on backwards too, that is in the box: the slab test. Empty
// (begin > end) where there is none.
[[nodiscard]] inline RaySpan span_in_box(const Box& box, Vec3 origin, Vec3 direction) {
  RaySpan span{-kInfinity, kInfinity};
  const double from[] = {origin.x, origin.y, origin.z};
  const double ahead[] = {direction.x, direction.y, direction.z};
  const double low[] = {box.min.x, box.min.y, box.min.z};
  const double high[] = {box.max.x, box.max.y, box.max.z};
  for (int axis = 0; axis < 3; ++axis) {
    const double a = low[axis] - from[axis];
    const double b = high[axis] - from[axis];
    if (ahead[axis] == 0) {
      if (a > 0 || b < 0) return {kInfinity, -kInfinity};
      continue;
    }
    span.begin = std::max(span.begin, std::min(a / ahead[axis], b / ahead[axis]));
    span.end = std::min(span.end, std::max(a / ahead[axis], b / ahead[axis]));
  }
  return span;
}

}  // namespace geodesic
