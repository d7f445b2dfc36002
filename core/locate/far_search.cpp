#include "core/locate/far_search.h"

#include <algorithm>
#include <array>
#include <limits>

namespace geodesic {

struct FarSearch::Query {
  // The h of far_search.h. It is the same sum for a point and for the best point of a box, so that
  // a vertex in the corner of its box has exactly the value of the box.
  struct Height {
    explicit Height(Vec3 from) : q(from), u((1 / norm(from)) * from), curvature(0.5 / norm(from)) {}

    [[nodiscard]] double at(Vec3 x) const {
      return x.x * (x.x * curvature - u.x) + x.y * (x.y * curvature - u.y) +
             x.z * (x.z * curvature - u.z);
    }
    // h is convex in each coordinate, and least where the coordinate is q's.
    [[nodiscard]] double least_in(const Box& box) const {
      return at({std::clamp(q.x, box.min.x, box.max.x), std::clamp(q.y, box.min.y, box.max.y),
                 std::clamp(q.z, box.min.z, box.max.z)});
    }

    Vec3 q;
    Vec3 u;
    double curvature;
  };

  Query(const FarSearch& search, Vec3 from, const Cancel& cancel)
      : search(search), height(from), poll(cancel) {}

  [[nodiscard]] double least_in(const Box& box) const { return height.least_in(box); }

  // Whether a box has nothing better than the best so far. In the box h is nowhere below `least`,
  // and its faces begin with `first_face`.
  [[nodiscard]] bool is_beaten(double least, std::size_t first_face) const {
    return least > best || (least == best && first_face > found.face);
  }

  void offer(double value, std::uint32_t face, const TriangleWeights& bary) {
    if (value > best || (value == best && face >= found.face)) return;
    best = value;
    found = {face, bary};
  }

  [[nodiscard]] bool is_cancelled() { return poll.cancelled(); }

  // Tries the foot and all three sides: from so far away, rounding may misplace the foot.
  void consider(std::uint32_t face) {
    const Triangle& t = search.mesh_.faces()[face];
    const auto inside = [&](std::size_t c) {
      return search.unit_.inside(search.mesh_.positions()[t[c]]);
    };
    const std::array<Vec3, 3> corner{inside(0), inside(1), inside(2)};
    const Vec3 p = height.q;
    if (auto bary = foot_inside(p, corner)) {
      const double sum = (*bary)[0] + (*bary)[1] + (*bary)[2];
      for (double& weight : *bary) weight /= sum;
      offer(height.at((*bary)[0] * corner[0] + (*bary)[1] * corner[1] + (*bary)[2] * corner[2]),
            face, *bary);
    }
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Vec3 a = corner[c];
      const Vec3 b = corner[next_corner(c)];
      const double t = foot_on_segment(p, a, b);
      TriangleWeights bary{0, 0, 0};
      bary[c] = 1 - t;
      bary[next_corner(c)] = t;
      offer(height.at((1 - t) * a + t * b), face, bary);
    }
  }

  const FarSearch& search;
  Height height;
  Poll poll;
  double best = kInfinity;
  Found found;
};

FarSearch::Found FarSearch::closest(Vec3 q, const Cancel& cancel) const {
  Query query(*this, q, cancel);
  boxes_.visit(query);
  if (query.poll.stopped()) return {};
  return query.found;
}

}  // namespace geodesic
