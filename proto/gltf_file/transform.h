// The affine transform of a glTF node, in double precision.
#pragma once

#include <array>
#include <span>

#include "core/base/vec3.h"

namespace geodesic::proto {

// Columns of the linear part and a translation: p -> x*p.x + y*p.y + z*p.z + t.
struct GltfTransform {
  Vec3 x{1, 0, 0};
  Vec3 y{0, 1, 0};
  Vec3 z{0, 0, 1};
  Vec3 t{0, 0, 0};

  [[nodiscard]] Vec3 direction(Vec3 v) const { return v.x * x + v.y * y + v.z * z; }
  [[nodiscard]] Vec3 point(Vec3 p) const { return direction(p) + t; }

  // First `inner`, then this.
  [[nodiscard]] GltfTransform after(const GltfTransform& inner) const {
    return {direction(inner.x), direction(inner.y), direction(inner.z), point(inner.t)};
  }

  friend bool operator==(const GltfTransform&, const GltfTransform&) = default;
};

// Of 16 numbers in column-major order; the last row is taken to be 0 0 0 1.
[[nodiscard]] inline GltfTransform transform_of_matrix(std::span<const double, 16> m) {
  return {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
}

// Translation after rotation (quaternion x y z w, unit length) after scale.
[[nodiscard]] inline GltfTransform transform_of_trs(Vec3 t, const std::array<double, 4>& q,
                                                    Vec3 scale) {
  const auto [x, y, z, w] = q;
  return {scale.x * Vec3{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
          scale.y * Vec3{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
          scale.z * Vec3{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}, t};
}

}  // namespace geodesic::proto
