// The body is the zero set of a smooth union of capsules, made into triangles by
// surface nets (Gibson 1998): one vertex in each cell of a grid that the surface
// crosses, one quadrilateral round each grid edge that it crosses.
#include "tests/paper/report/generated_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/vec3.h"

namespace geodesic::report {
namespace {

struct Capsule {
  Vec3 from, to;
  double from_radius, to_radius;
};

constexpr Capsule kParts[] = {
    {{-0.45, 0.02, 0}, {0.50, 0.04, 0}, 0.25, 0.27},              // trunk
    {{-0.55, 0.12, 0}, {-0.78, 0.52, 0.05}, 0.17, 0.11},          // neck
    {{-0.78, 0.56, 0.05}, {-1.06, 0.34, 0.14}, 0.11, 0.065},      // head
    {{-0.73, 0.62, 0.10}, {-0.71, 0.73, 0.12}, 0.035, 0.015},     // ears
    {{-0.75, 0.62, 0.00}, {-0.73, 0.73, -0.02}, 0.035, 0.015},    //
    {{-0.42, -0.05, 0.13}, {-0.50, -0.75, 0.14}, 0.11, 0.055},    // legs
    {{-0.36, -0.05, -0.13}, {-0.30, -0.75, -0.14}, 0.11, 0.055},  //
    {{0.52, -0.05, 0.13}, {0.62, -0.75, 0.14}, 0.14, 0.055},      //
    {{0.46, -0.05, -0.13}, {0.44, -0.75, -0.14}, 0.14, 0.055},    //
    {{0.74, 0.12, 0}, {0.98, -0.30, 0.03}, 0.05, 0.04},           // tail
};
constexpr Vec3 kLow{-1.25, -0.95, -0.45};
constexpr Vec3 kHigh{1.15, 0.90, 0.45};

// Below zero inside.
double depth(Vec3 p) {
  constexpr double kBlend = 0.07;
  double least = 10;
  for (const Capsule& part : kParts) {
    const Vec3 axis = part.to - part.from;
    const double t = std::clamp(dot(p - part.from, axis) / dot(axis, axis), 0.0, 1.0);
    const double radius = part.from_radius + t * (part.to_radius - part.from_radius);
    const double d = distance(p, part.from + t * axis) - radius;
    // The smooth minimum of two: a parabola where they are closer than kBlend.
    const double h = std::max(kBlend - std::abs(least - d), 0.0) / kBlend;
    least = std::min(least, d) - 0.25 * h * h * kBlend;
  }
  return least;
}

class SurfaceNets {
 public:
  explicit SurfaceNets(std::uint32_t cells)
      : step_((kHigh.x - kLow.x) / cells),
        nx_(cells + 1),
        ny_(points_along(kLow.y, kHigh.y)),
        nz_(points_along(kLow.z, kHigh.z)) {}

  TriangleSoup run() {
    depth_.resize(std::size_t{nx_} * ny_ * nz_);
    for_each(nx_, ny_, nz_, [&](Index at) { depth_[number(at)] = depth(position(at)); });
    cell_vertex_.resize(depth_.size());
    for_each(nx_ - 1, ny_ - 1, nz_ - 1, [&](Index at) { place_vertex(at); });
    for_each(nx_ - 1, ny_ - 1, nz_ - 1, [&](Index at) {
      for (std::size_t axis = 0; axis < 3; ++axis) join_round_edge(at, axis);
    });
    return std::move(soup_);
  }

 private:
  using Index = std::array<std::uint32_t, 3>;

  template <class Visit>
  static void for_each(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, Visit visit) {
    for (std::uint32_t k = 0; k < nz; ++k) {
      for (std::uint32_t j = 0; j < ny; ++j) {
        for (std::uint32_t i = 0; i < nx; ++i) visit(Index{i, j, k});
      }
    }
  }
  [[nodiscard]] std::uint32_t points_along(double low, double high) const {
    return static_cast<std::uint32_t>(std::ceil((high - low) / step_)) + 1;
  }
  [[nodiscard]] std::size_t number(Index at) const {
    return (std::size_t{at[2]} * ny_ + at[1]) * nx_ + at[0];
  }
  [[nodiscard]] Vec3 position(Index at) const {
    return kLow + step_ * Vec3{double(at[0]), double(at[1]), double(at[2])};
  }
  static Index plus(Index at, std::size_t axis) {
    ++at[axis];
    return at;
  }
  [[nodiscard]] bool crossed(Index a, Index b) const {
    return (depth_[number(a)] < 0) != (depth_[number(b)] < 0);
  }

  // In the middle of where the surface crosses the cell's twelve edges.
  void place_vertex(Index cell) {
    Vec3 sum;
    int crossings = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t u = (axis + 1) % 3;
      const std::size_t v = (axis + 2) % 3;
      for (const Index from : {cell, plus(cell, u), plus(cell, v), plus(plus(cell, u), v)}) {
        const Index to = plus(from, axis);
        if (!crossed(from, to)) continue;
        const double a = depth_[number(from)];
        const double b = depth_[number(to)];
        sum = sum + position(from) + (a / (a - b)) * (position(to) - position(from));
        ++crossings;
      }
    }
    if (crossings == 0) return;
    cell_vertex_[number(cell)] = static_cast<std::uint32_t>(soup_.positions.size());
    soup_.positions.push_back((1.0 / crossings) * sum);
  }

  // The four cells round a crossed edge. The grid is wide enough that the surface
  // stays clear of its sides.
  void join_round_edge(Index at, std::size_t axis) {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    if (at[u] == 0 || at[v] == 0 || !crossed(at, plus(at, axis))) return;
    Index beside = at;
    --beside[u];
    Index below = at;
    --below[v];
    Index across = beside;
    --across[v];
    const std::uint32_t a = cell_vertex_[number(across)];
    const std::uint32_t b = cell_vertex_[number(below)];
    const std::uint32_t c = cell_vertex_[number(at)];
    const std::uint32_t d = cell_vertex_[number(beside)];
    soup_.faces.push_back({a, b, c});
    soup_.faces.push_back({a, c, d});
  }

  double step_;
  std::uint32_t nx_, ny_, nz_;  // grid points
  std::vector<double> depth_;
  std::vector<std::uint32_t> cell_vertex_;  // by the cell's first grid point
  TriangleSoup soup_;
};

}  // namespace

TriangleSoup generated_body(std::uint32_t cells) { return SurfaceNets(cells).run(); }

}  // namespace geodesic::report
