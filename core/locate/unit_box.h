// The frame in which points in space are searched for.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/vec3.h"
#include "core/mesh/mesh.h"

namespace geodesic {

[[nodiscard]] inline double largest_component(Vec3 v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

// A mesh moved and scaled into the box [-1, 1]: neither a huge nor a tiny one overflows there. The
// scale is a power of two, by which nothing is rounded.
struct UnitBox {
  explicit UnitBox(const Box& box) : centre(0.5 * box.min + 0.5 * box.max) {
    int exponent = 0;
    std::frexp(largest_component(0.5 * box.max - 0.5 * box.min), &exponent);
    scale = std::ldexp(1.0, -exponent);
  }
  [[nodiscard]] Vec3 inside(Vec3 p) const { return scale * (p - centre); }

  Vec3 centre;
  double scale;
};

}  // namespace geodesic
