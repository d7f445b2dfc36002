#include "proto/mesh/polygon_soup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace geodesic::proto {
namespace {

using Face = std::array<std::uint32_t, 3>;

constexpr std::size_t kMostCutCorners = 256;
// Looks at a corner in all cutting of one file; then faces become fans. A second's work.
constexpr std::uint64_t kMostLooks = 300'000'000;

struct Point {
  double x;
  double y;
};

double turn(Point a, Point b, Point c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Cuts one polygon after another, with memory that it keeps.
class EarCutter {
 public:
  // Appends triangles. False: they are a fan although the polygon is not convex.
  bool cut(std::span<const std::uint32_t> corners, const std::vector<Vec3>& positions,
           std::vector<Face>& out) {
    project(corners, positions);
    if (is_convex() || corners.size() == 3) {
      fan(corners, out);
      return true;
    }
    if (corners.size() > kMostCutCorners || looks_ > kMostLooks) {
      fan(corners, out);
      return false;
    }
    const std::size_t before = out.size();
    if (clip(corners, out)) return true;
    out.resize(before);  // it crosses itself
    fan(corners, out);
    return false;
  }

 private:
  static void fan(std::span<const std::uint32_t> corners, std::vector<Face>& out) {
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
      out.push_back({corners[0], corners[i], corners[i + 1]});
    }
  }

  // Onto the coordinate plane that the Newell normal looks at most, so that the
  // polygon turns counter-clockwise.
  void project(std::span<const std::uint32_t> corners, const std::vector<Vec3>& positions) {
    Vec3 normal{0, 0, 0};
    const Vec3 origin = positions[corners[0]];
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec3 p = positions[corners[i]] - origin;
      const Vec3 q = positions[corners[(i + 1) % corners.size()]] - origin;
      normal = normal + cross(p, q);
    }
    const Vec3 size{std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
    points_.clear();
    for (const std::uint32_t corner : corners) {
      const Vec3 p = positions[corner] - origin;
      if (size.z >= size.x && size.z >= size.y) {
        points_.push_back(normal.z >= 0 ? Point{p.x, p.y} : Point{p.y, p.x});
      } else if (size.y >= size.x) {
        points_.push_back(normal.y >= 0 ? Point{p.z, p.x} : Point{p.x, p.z});
      } else {
        points_.push_back(normal.x >= 0 ? Point{p.y, p.z} : Point{p.z, p.y});
      }
    }
  }

  // Turns left at every corner and goes round once: then each fan triangle does too.
  [[nodiscard]] bool is_convex() const {
    const std::size_t n = points_.size();
    for (std::size_t i = 0; i < n; ++i) {
      if (turn(points_[i], points_[(i + 1) % n], points_[(i + 2) % n]) < 0) return false;
    }
    for (std::size_t i = 1; i + 1 < n; ++i) {
      if (turn(points_[0], points_[i], points_[i + 1]) < 0) return false;
    }
    return true;
  }

  [[nodiscard]] bool is_ear(std::size_t at) {
    const std::size_t n = left_.size();
    const std::size_t before = left_[(at + n - 1) % n];
    const std::size_t tip = left_[at];
    const std::size_t after = left_[(at + 1) % n];
    const Point a = points_[before];
    const Point b = points_[tip];
    const Point c = points_[after];
    if (turn(a, b, c) <= 0) return false;
    looks_ += n;
    for (const std::size_t other : left_) {
      if (other == before || other == tip || other == after) continue;
      const Point p = points_[other];
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  }

  bool clip(std::span<const std::uint32_t> corners, std::vector<Face>& out) {
    left_.resize(corners.size());
    for (std::size_t i = 0; i < left_.size(); ++i) left_[i] = i;
    while (left_.size() > 3) {
      std::size_t at = 0;
      while (at < left_.size() && !is_ear(at)) ++at;
      if (at == left_.size()) return false;
      const std::size_t n = left_.size();
      out.push_back(
          {corners[left_[(at + n - 1) % n]], corners[left_[at]], corners[left_[(at + 1) % n]]});
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(at));
    }
    out.push_back({corners[left_[0]], corners[left_[1]], corners[left_[2]]});
    return true;
  }

  std::vector<Point> points_;
  std::vector<std::size_t> left_;
  std::uint64_t looks_ = 0;
};

}  // namespace

Result<void> PolygonSoup::add_vertex(Vec3 position) {
  const auto most = std::min<std::uint64_t>(limits_.max_vertices, 0xFFFFFFFF);
  if (positions_.size() >= most) {
    return fail_limit(ErrorCode::too_many_vertices, "The mesh has too many vertices.", most,
                      positions_.size() + 1);
  }
  positions_.push_back(position);
  return {};
}

Result<void> PolygonSoup::add_face(std::span<const std::uint32_t> corners) {
  triangles_ += corners.size() - 2;
  if (triangles_ > limits_.max_faces) {
    return fail_limit(ErrorCode::too_many_faces, "The mesh has too many faces.", limits_.max_faces,
                      triangles_);
  }
  corners_.insert(corners_.end(), corners.begin(), corners.end());
  sizes_.push_back(static_cast<std::uint32_t>(corners.size()));
  return {};
}

Result<TriangleSoup> PolygonSoup::triangulated(Findings& findings) && {
  if (sizes_.empty()) {
    return fail(ErrorCode::no_triangles,
                positions_.empty() ? "The file has no vertices." : "The file has no faces.");
  }
  TriangleSoup soup;
  soup.faces.reserve(triangles_);
  EarCutter cutter;
  std::size_t begin = 0;
  for (std::size_t f = 0; f < sizes_.size(); ++f) {
    const std::span<const std::uint32_t> corners(corners_.data() + begin, sizes_[f]);
    begin += sizes_[f];
    for (const std::uint32_t corner : corners) {
      if (corner >= positions_.size()) {
        return fail(ErrorCode::index_out_of_range,
                    "Face " + std::to_string(f) + " refers to vertex " + std::to_string(corner) +
                        ", counted from 0, but there are " + std::to_string(positions_.size()) +
                        ".");
      }
    }
    const std::string name = "face " + std::to_string(f);
    const bool is_clean = cutter.cut(corners, positions_, soup.faces);
    if (corners.size() > 3) {
      findings.add("polygons_triangulated", name, "has more than three corners and was cut");
    }
    if (!is_clean) {
      findings.add("polygons_as_fans", name,
                   "crosses itself or has very many corners and was cut as a fan");
    }
  }
  soup.positions = std::move(positions_);
  return soup;
}

}  // namespace geodesic::proto
