#include "core/locate/near_search.h"

#include <array>

namespace geodesic {
namespace {

struct OnTriangle {
  double distance2;
  TriangleWeights bary;
};

OnTriangle closest_on_triangle(Vec3 p, const std::array<Vec3, 3>& corner) {
  if (const auto bary = foot_inside(p, corner)) {
    // From the place itself, whatever rounding made of it.
    const Vec3 gap =
        p - corner[0] - (*bary)[1] * (corner[1] - corner[0]) - (*bary)[2] * (corner[2] - corner[0]);
    return {dot(gap, gap), *bary};
  }
  OnTriangle best{std::numeric_limits<double>::infinity(), {1, 0, 0}};
  for (std::uint32_t c = 0; c < 3; ++c) {
    const Vec3 a = corner[c];
    const Vec3 b = corner[next_corner(c)];
    const double t = foot_on_segment(p, a, b);
    const Vec3 gap = p - ((1 - t) * a + t * b);
    const double distance2 = dot(gap, gap);
    if (distance2 < best.distance2) {
      best = {distance2, {0, 0, 0}};
      best.bary[c] = 1 - t;
      best.bary[next_corner(c)] = t;
    }
  }
  return best;
}

}  // namespace

bool NearSearch::consider(std::uint32_t face) {
  const Triangle& t = mesh_.faces()[face];
  const auto positions = mesh_.positions();
  const OnTriangle found =
      closest_on_triangle(from_, {positions[t[0]], positions[t[1]], positions[t[2]]});
  if (found.distance2 > best2_ || (found.distance2 == best2_ && face > face_)) return false;
  best2_ = found.distance2;
  face_ = face;
  bary_ = found.bary;
  return true;
}

}  // namespace geodesic
