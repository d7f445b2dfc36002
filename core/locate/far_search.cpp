#include "core/locate/far_search.h"

#include <algorithm>
#include <array>
#include <limits>

namespace geodesic {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kFacesOfBox = 16;
constexpr std::size_t kBoxesOfBox = 8;

void grow(Box& box, const Box& other) {
  box.min = {std::min(box.min.x, other.min.x), std::min(box.min.y, other.min.y),
             std::min(box.min.z, other.min.z)};
  box.max = {std::max(box.max.x, other.max.x), std::max(box.max.y, other.max.y),
             std::max(box.max.z, other.max.z)};
}

constexpr Box kEmpty{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

// The h of far_search.h. It is the same sum for a point and for the best point of a box, so that a
// vertex in the corner of its box has exactly the value of the box.
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

}  // namespace

struct FarSearch::Query {
  Query(Vec3 from, const Cancel& cancel) : height(from), poll(cancel) {}

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

  // Tries the foot and all three sides: from so far away, rounding may misplace the foot.
  void consider(std::uint32_t face, const std::array<Vec3, 3>& corner) {
    const Vec3 p = height.q;
    const Vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    if (auto bary = foot_inside(p, corner, normal)) {
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

  Height height;
  Poll poll;
  double best = kInfinity;
  Found found;
};

FarSearch::FarSearch(const Mesh& mesh, const UnitBox& unit, Poll& poll) : mesh_(mesh), unit_(unit) {
  std::vector<Box> boxes((mesh.face_count() + kFacesOfBox - 1) / kFacesOfBox, kEmpty);
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    if (poll.cancelled()) break;
    for (const std::uint32_t v : mesh.faces()[f]) {
      const Vec3 corner = unit.inside(mesh.positions()[v]);
      grow(boxes[f / kFacesOfBox], {corner, corner});
    }
  }
  levels_.push_back(std::move(boxes));
  while (levels_.back().size() > 1) {
    const std::vector<Box>& below = levels_.back();
    std::vector<Box> above((below.size() + kBoxesOfBox - 1) / kBoxesOfBox, kEmpty);
    for (std::size_t i = 0; i < below.size(); ++i) grow(above[i / kBoxesOfBox], below[i]);
    levels_.push_back(std::move(above));
  }
}

FarSearch::Found FarSearch::closest(Vec3 q, const Cancel& cancel) const {
  Query query(q, cancel);
  search(query, levels_.size() - 1, 0);
  if (query.poll.stopped()) return {};
  return query.found;
}

// The recursion is as deep as there are levels: 11 for 2^32 faces.
void FarSearch::search(Query& query, std::size_t level, std::size_t block) const {
  if (level == 0) {
    const std::size_t end = std::min<std::size_t>((block + 1) * kFacesOfBox, mesh_.face_count());
    for (std::size_t f = block * kFacesOfBox; f < end; ++f) {
      if (query.poll.cancelled()) return;
      const Triangle& t = mesh_.faces()[f];
      const auto corner = [&](std::size_t c) { return unit_.inside(mesh_.positions()[t[c]]); };
      query.consider(static_cast<std::uint32_t>(f), {corner(0), corner(1), corner(2)});
    }
    return;
  }
  const std::vector<Box>& below = levels_[level - 1];
  struct Next {
    double least;
    std::size_t block;
  };
  // The whole array is sorted, unused entries last: GCC 14 falsely warns of an overrun if only
  // the used ones are sorted.
  std::array<Next, kBoxesOfBox> order;
  order.fill({std::numeric_limits<double>::infinity(), below.size()});
  std::size_t count = 0;
  for (std::size_t i = block * kBoxesOfBox; i < std::min((block + 1) * kBoxesOfBox, below.size());
       ++i) {
    order[count++] = {query.height.least_in(below[i]), i};
  }
  std::sort(order.begin(), order.end(), [](const Next& a, const Next& b) {
    return a.least < b.least || (a.least == b.least && a.block < b.block);
  });
  std::size_t faces_of_block = kFacesOfBox;
  for (std::size_t l = 1; l < level; ++l) faces_of_block *= kBoxesOfBox;
  for (std::size_t i = 0; i < count; ++i) {
    if (query.poll.stopped()) return;
    if (query.is_beaten(order[i].least, order[i].block * faces_of_block)) continue;
    search(query, level - 1, order[i].block);
  }
}

std::size_t FarSearch::bytes() const {
  std::size_t bytes = sizeof(*this);
  for (const std::vector<Box>& level : levels_) bytes += level.capacity() * sizeof(Box);
  return bytes;
}

}  // namespace geodesic
