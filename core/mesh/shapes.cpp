#include "core/mesh/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

namespace geodesic::shapes {
namespace {

using std::numbers::pi;

// SplitMix64 (Steele, Lea and Flood 2014): the same numbers on every platform,
// which std::uniform_real_distribution does not promise.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
  }
  double unit() { return static_cast<double>(next() >> 11U) * 0x1p-53; }  // [0, 1)
  std::uint32_t below(std::uint32_t bound) {
    return static_cast<std::uint32_t>(unit() * static_cast<double>(bound));
  }

 private:
  std::uint64_t state_;
};

template <class Visible>
void add_grid_faces(TriangleSoup& soup, std::uint32_t columns, std::uint32_t rows,
                    Diagonal diagonal, Visible visible) {
  for (std::uint32_t j = 0; j + 1 < rows; ++j) {
    for (std::uint32_t i = 0; i + 1 < columns; ++i) {
      if (!visible(i, j)) continue;
      const std::uint32_t a = j * columns + i;
      const std::uint32_t b = a + 1;
      const std::uint32_t c = a + columns;
      const std::uint32_t d = c + 1;
      if (diagonal == Diagonal::rising) {
        soup.faces.push_back({a, b, d});
        soup.faces.push_back({a, d, c});
      } else {
        soup.faces.push_back({a, b, c});
        soup.faces.push_back({b, d, c});
      }
    }
  }
}

template <class Height>
TriangleSoup height_field(std::uint32_t columns, std::uint32_t rows, Diagonal diagonal,
                          Height height) {
  TriangleSoup soup;
  soup.positions.reserve(std::size_t{columns} * rows);
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      soup.positions.push_back({double(i), double(j), height(double(i), double(j))});
    }
  }
  add_grid_faces(soup, columns, rows, diagonal, [](std::uint32_t, std::uint32_t) { return true; });
  return soup;
}

}  // namespace

TriangleSoup plane(std::uint32_t columns, std::uint32_t rows, Diagonal diagonal) {
  return height_field(columns, rows, diagonal, [](double, double) { return 0.0; });
}

TriangleSoup plane_with_holes(std::uint32_t columns, std::uint32_t rows,
                              std::span<const Hole> holes, Diagonal diagonal) {
  TriangleSoup soup = plane(columns, rows, diagonal);
  soup.faces.clear();
  add_grid_faces(soup, columns, rows, diagonal, [&](std::uint32_t i, std::uint32_t j) {
    return std::none_of(holes.begin(), holes.end(), [&](const Hole& hole) {
      return i >= hole.first_column && i < hole.first_column + hole.size && j >= hole.first_row &&
             j < hole.first_row + hole.size;
    });
  });
  return soup;
}

TriangleSoup icosphere(std::uint32_t levels) {
  const double t = std::numbers::phi;
  TriangleSoup soup;
  soup.positions = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                    {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  soup.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (Vec3& p : soup.positions) p = (1 / norm(p)) * p;
  for (std::uint32_t level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(soup.positions.size()));
      if (fresh) {
        const Vec3 sum = soup.positions[a] + soup.positions[b];
        soup.positions.push_back((1 / norm(sum)) * sum);
      }
      return it->second;
    };
    std::vector<std::array<std::uint32_t, 3>> split;
    split.reserve(4 * soup.faces.size());
    for (const auto& [a, b, c] : soup.faces) {
      const std::uint32_t ab = middle(a, b);
      const std::uint32_t bc = middle(b, c);
      const std::uint32_t ca = middle(c, a);
      split.insert(split.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    soup.faces = std::move(split);
  }
  return soup;
}

TriangleSoup torus_knot(std::uint32_t around_knot, std::uint32_t around_tube, double tube_radius) {
  const auto centre = [](double u) {
    const double r = 2 + std::cos(3 * u);
    return Vec3{r * std::cos(2 * u), r * std::sin(2 * u), std::sin(3 * u)};
  };
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < around_knot; ++i) {
    const double u = 2 * pi * i / around_knot;
    const Vec3 at = centre(u);
    // A frame across the curve: the direction away from the axis, made normal to it.
    const Vec3 ahead = centre(u + 1e-4) - centre(u - 1e-4);
    const Vec3 tangent = (1 / norm(ahead)) * ahead;
    const Vec3 side = cross(tangent, Vec3{at.x, at.y, 2 * at.z});
    const Vec3 first = (1 / norm(side)) * side;
    const Vec3 second = cross(tangent, first);
    for (std::uint32_t j = 0; j < around_tube; ++j) {
      const double v = 2 * pi * j / around_tube;
      soup.positions.push_back(at + (tube_radius * std::cos(v)) * first +
                               (tube_radius * std::sin(v)) * second);
    }
  }
  const auto vertex = [&](std::uint32_t i, std::uint32_t j) {
    return (i % around_knot) * around_tube + j % around_tube;
  };
  for (std::uint32_t i = 0; i < around_knot; ++i) {
    for (std::uint32_t j = 0; j < around_tube; ++j) {
      soup.faces.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      soup.faces.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  }
  return soup;
}

TriangleSoup saddle(std::uint32_t side, double height) {
  const double half = 0.5 * (side - 1);
  return height_field(side, side, Diagonal::rising, [=](double x, double y) {
    const double u = x / half - 1;
    const double v = y / half - 1;
    return height * (u * u - v * v);
  });
}

TriangleSoup terrain(std::uint32_t side, double height, std::uint32_t seed) {
  struct Wave {
    double kx, ky, phase, size;
  };
  Random random(seed);
  // No wave shorter than a dozen triangles.
  const double finest = std::min(12.0, side / 12.0);
  std::array<Wave, 24> waves;
  for (std::size_t i = 0; i < waves.size(); ++i) {
    const double cycles = 1 + finest * random.unit() * random.unit();
    const double angle = 2 * pi * random.unit();
    const double k = 2 * pi * cycles / side;
    waves[i] = {k * std::cos(angle), k * std::sin(angle), 2 * pi * random.unit(), height / cycles};
  }
  TriangleSoup soup = plane(side, side);
  for (std::uint32_t j = 0; j < side; ++j) {
    for (std::uint32_t i = 0; i < side; ++i) {
      Vec3& p = soup.positions[std::size_t{j} * side + i];
      const bool inner = i > 0 && j > 0 && i + 1 < side && j + 1 < side;
      const double dx = 0.6 * (random.unit() - 0.5);
      const double dy = 0.6 * (random.unit() - 0.5);
      if (inner) p = {p.x + dx, p.y + dy, 0};
      for (const Wave& w : waves) p.z += w.size * std::sin(w.kx * p.x + w.ky * p.y + w.phase);
    }
  }
  return soup;
}

TriangleSoup shuffled(const TriangleSoup& soup, std::uint32_t seed) {
  Random random(seed);
  const auto permutation = [&](std::size_t size) {
    std::vector<std::uint32_t> order(size);
    std::iota(order.begin(), order.end(), 0U);
    for (std::size_t i = size; i > 1; --i) {
      std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
    }
    return order;
  };
  const auto new_number = permutation(soup.positions.size());
  const auto new_place = permutation(soup.faces.size());
  TriangleSoup result;
  result.positions.resize(soup.positions.size());
  result.faces.resize(soup.faces.size());
  for (std::size_t v = 0; v < new_number.size(); ++v) {
    result.positions[new_number[v]] = soup.positions[v];
  }
  for (std::size_t f = 0; f < new_place.size(); ++f) {
    std::array<std::uint32_t, 3> t = soup.faces[f];
    for (std::uint32_t& v : t) v = new_number[v];
    std::rotate(t.begin(), t.begin() + random.below(3), t.end());
    if (f % 2 == 0) std::swap(t[0], t[1]);
    result.faces[new_place[f]] = t;
  }
  return result;
}

}  // namespace geodesic::shapes
