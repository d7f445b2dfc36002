#include "tests/bench/irregular_plane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace geodesic::bench {
namespace {

constexpr std::uint32_t kOutside = std::numeric_limits<std::uint32_t>::max();

// Points are added one by one to the face that they lie in, whose edges are then flipped
// until no circle round a face has another face's vertex in it (Lawson 1977).
class Delaunay {
 public:
  // In a square about the points, of which the first four are the corners.
  explicit Delaunay(std::vector<Vec3> points) : points_(std::move(points)) {
    faces_.push_back({{0, 1, 2}, {kOutside, 1, kOutside}});
    faces_.push_back({{0, 2, 3}, {kOutside, kOutside, 0}});
    for (std::uint32_t p = 4; p < points_.size(); ++p) add(p);
  }

  // The faces that none of the four corners is in.
  [[nodiscard]] std::vector<std::array<std::uint32_t, 3>> faces_within() const {
    std::vector<std::array<std::uint32_t, 3>> within;
    for (const Face& face : faces_) {
      const auto& v = face.vertex;
      if (std::min({v[0], v[1], v[2]}) > 3) within.push_back(v);
    }
    return within;
  }

  [[nodiscard]] const std::vector<Vec3>& points() const { return points_; }

 private:
  struct Face {
    std::array<std::uint32_t, 3> vertex;  // counterclockwise
    std::array<std::uint32_t, 3> beyond;  // the face opposite each
  };

  // Twice the area, positive where c is to the left of the way from a to b.
  [[nodiscard]] double area2(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Vec3 &p = points_[a], &q = points_[b], &r = points_[c];
    return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
  }

  [[nodiscard]] bool in_circle(const std::array<std::uint32_t, 3>& face, std::uint32_t d) const {
    std::array<std::array<double, 3>, 3> row;
    for (std::size_t i = 0; i < 3; ++i) {
      const double x = points_[face[i]].x - points_[d].x;
      const double y = points_[face[i]].y - points_[d].y;
      row[i] = {x, y, x * x + y * y};
    }
    const auto minor = [&](std::size_t i, std::size_t j) {
      return row[i][0] * row[j][1] - row[i][1] * row[j][0];
    };
    return row[0][2] * minor(1, 2) + row[1][2] * minor(2, 0) + row[2][2] * minor(0, 1) > 1e-9;
  }

  void add(std::uint32_t p) {
    for (std::size_t i = 0; i < 3;) {
      const auto& [vertex, beyond] = faces_[last_];
      if (area2(vertex[(i + 1) % 3], vertex[(i + 2) % 3], p) < 0) {
        last_ = beyond[i];
        i = 0;
      } else {
        ++i;
      }
    }
    const Face old = faces_[last_];
    const auto [a, b, c] = old.vertex;
    const auto second = static_cast<std::uint32_t>(faces_.size());
    const std::uint32_t third = second + 1;
    faces_[last_] = {{a, b, p}, {second, third, old.beyond[2]}};
    faces_.push_back({{b, c, p}, {third, last_, old.beyond[0]}});
    faces_.push_back({{c, a, p}, {last_, second, old.beyond[1]}});
    look_from(old.beyond[0], last_, second);
    look_from(old.beyond[1], last_, third);
    flip_round(p, {last_, second, third});
  }

  // `face` has `to` on the side where it had `from`.
  void look_from(std::uint32_t face, std::uint32_t from, std::uint32_t to) {
    if (face != kOutside)
      *std::find(begin(faces_[face].beyond), end(faces_[face].beyond), from) = to;
  }

  // Of these faces p is the last vertex.
  void flip_round(std::uint32_t p, std::vector<std::uint32_t> waiting) {
    while (!waiting.empty()) {
      const std::uint32_t f = waiting.back();
      waiting.pop_back();
      const std::uint32_t g = faces_[f].beyond[2];
      if (g == kOutside || !in_circle(faces_[g].vertex, p)) continue;
      const Face face = faces_[f];
      const Face other = faces_[g];
      const std::uint32_t a = face.vertex[0];
      const std::uint32_t b = face.vertex[1];
      const auto at = static_cast<std::size_t>(
          std::find(begin(other.beyond), end(other.beyond), f) - begin(other.beyond));
      const std::uint32_t apex = other.vertex[at];
      const std::uint32_t over_a = other.beyond[(at + 1) % 3];
      const std::uint32_t over_b = other.beyond[(at + 2) % 3];
      faces_[f] = {{a, apex, p}, {g, face.beyond[1], over_a}};
      faces_[g] = {{apex, b, p}, {face.beyond[0], f, over_b}};
      look_from(over_a, g, f);
      look_from(face.beyond[0], f, g);
      waiting.push_back(f);
      waiting.push_back(g);
    }
  }

  std::vector<Vec3> points_;
  std::vector<Face> faces_;
  std::uint32_t last_ = 0;
};

// From row to row and back, so that each point is near the one before.
std::vector<Vec3> points_at_random(std::uint32_t count, double side, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto unit = [&random] { return static_cast<double>(random()) / 4294967296.0; };
  std::vector<Vec3> points(count);
  for (Vec3& p : points) {
    const double x = side * unit();
    p = {x, side * unit(), 0};
  }
  const auto row = [](const Vec3& p) { return static_cast<std::uint32_t>(p.y); };
  std::sort(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) {
    if (row(a) != row(b)) return row(a) < row(b);
    return row(a) % 2 == 0 ? a.x < b.x : b.x < a.x;
  });
  return points;
}

}  // namespace

TriangleSoup irregular_plane(std::uint32_t count, double height, std::uint32_t seed) {
  const double side = std::sqrt(count);
  // Far away, so that the border is nearly that of the points' hull.
  const double away = 20 * side;
  std::vector<Vec3> points{{-away, -away, 0}, {away, -away, 0}, {away, away, 0}, {-away, away, 0}};
  for (const Vec3& p : points_at_random(count, side, seed)) points.push_back(p);
  const Delaunay delaunay(std::move(points));
  TriangleSoup soup;
  soup.positions.assign(delaunay.points().begin() + 4, delaunay.points().end());
  for (const auto& v : delaunay.faces_within())
    soup.faces.push_back({v[0] - 4, v[1] - 4, v[2] - 4});
  const double once = 2 * std::numbers::pi / side;
  for (Vec3& p : soup.positions) {
    p.z = 0.5 * height * std::sin(2.5 * once * p.x) * std::sin(2.5 * once * p.y) +
          0.1 * height * std::sin(once * (11 * p.x + 7 * p.y)) *
              std::sin(once * (13 * p.y - 5 * p.x));
  }
  return soup;
}

}  // namespace geodesic::bench
