// Where a ray meets triangles, in double precision and without gaps between them.
//
// After Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", 2013: space
// is moved and sheared so that the ray is an axis, and a triangle is hit if the
// origin of the plane across it is inside its projection. Each vertex is projected
// by itself, so that all triangles of a vertex agree on where it is; and on which
// side of an edge the ray passes, two triangles agree because that sign is exact.
// The border counts as inside. So no ray slips through a closed surface, whichever
// edge or vertex it is aimed at.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/base/vec3.h"

namespace geodesic {

class RayFrame {
 public:
  struct Hit {
    double t;                    // in lengths of the direction's largest component; not negative
    std::array<double, 3> bary;  // not negative, with sum 1 up to rounding
  };

  // The direction's largest component must be 1 or -1.
  explicit RayFrame(Vec3 direction) {
    const std::array<double, 3> d{direction.x, direction.y, direction.z};
    for (std::size_t axis = 1; axis < 3; ++axis) {
      if (std::abs(d[axis]) > std::abs(d[along_])) along_ = axis;
    }
    across_ = {(along_ + 1) % 3, (along_ + 2) % 3};
    sign_ = d[along_];
    slope_ = {d[across_[0]] / sign_, d[across_[1]] / sign_};
  }

  // `corner`: relative to where the ray begins. Nothing for a triangle that the ray
  // sees edge-on, or that has no area.
  [[nodiscard]] std::optional<Hit> meet(const std::array<Vec3, 3>& corner) const {
    const std::array<Projected, 3> p{project(corner[0]), project(corner[1]), project(corner[2])};
    std::array<double, 3> weight{};
    for (std::size_t c = 0; c < 3; ++c) {
      const Projected& a = p[(c + 1) % 3];
      const Projected& b = p[(c + 2) % 3];
      weight[c] = difference_of_products(a.x, b.y, a.y, b.x);
    }
    const bool any_below = weight[0] < 0 || weight[1] < 0 || weight[2] < 0;
    const bool any_above = weight[0] > 0 || weight[1] > 0 || weight[2] > 0;
    if (any_below == any_above) return std::nullopt;  // outside, or seen edge-on
    const double sum = weight[0] + weight[1] + weight[2];
    Hit hit{0, {}};
    for (std::size_t c = 0; c < 3; ++c) {
      hit.bary[c] = weight[c] / sum;
      hit.t += hit.bary[c] * p[c].t;
    }
    if (!(hit.t >= 0)) return std::nullopt;
    return hit;
  }

 private:
  struct Projected {
    double x;
    double y;
    double t;
  };

  [[nodiscard]] Projected project(Vec3 point) const {
    const std::array<double, 3> r{point.x, point.y, point.z};
    const double depth = r[along_];
    return {r[across_[0]] - slope_[0] * depth, r[across_[1]] - slope_[1] * depth, sign_ * depth};
  }

  // a b - c d with the right sign: Kahan's way has an error below two units in the
  // last place, so only an exact zero is zero.
  [[nodiscard]] static double difference_of_products(double a, double b, double c, double d) {
    const double cd = c * d;
    const double lost = std::fma(-c, d, cd);
    return std::fma(a, b, -cd) + lost;
  }

  std::size_t along_ = 0;
  std::array<std::size_t, 2> across_{};
  double sign_ = 1;
  std::array<double, 2> slope_{};
};

}  // namespace geodesic
