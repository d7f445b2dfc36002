// Fields from lines, and curves on planes that are held against closed forms.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/curves/source_lines.h"
#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "core/solve/curve_lines.h"
#include "core/solve/distance_at_point.h"
#include "core/solve/solve_from_lines.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/to_segment.h"

namespace geodesic::fixtures {

constexpr std::size_t kManyPieces = 1'000'000;

class LineQuestion {
 public:
  explicit LineQuestion(const Surface& surface) : surface_(surface) {}

  double curve(const std::vector<SurfacePoint>& points, bool is_closed) {
    const auto length = add_curve(surface_.adjacency(), points, is_closed, items_++, kManyPieces,
                                  lines_, sources_, scratch_, Cancel());
    REQUIRE(length);
    return *length;
  }
  void boundary() {
    Poll poll(cancel_);
    for (const BoundaryLoop& loop : boundary_loops(surface_.adjacency(), poll)) {
      add_edges(surface_.adjacency(), loop.edges, items_, lines_, sources_, poll);
    }
    ++items_;
  }
  void loop(const BoundaryLoop& of) {
    Poll poll(cancel_);
    add_edges(surface_.adjacency(), of.edges, items_++, lines_, sources_, poll);
  }
  void faces(const std::vector<std::uint32_t>& of) {
    Poll poll(cancel_);
    add_faces(surface_.adjacency(), of, items_++, lines_, sources_, poll);
  }
  void merge() {
    Poll poll(cancel_);
    merge_repeated(surface_.adjacency(), lines_, sources_, poll);
  }
  void point(const SurfacePoint& at) {
    sources_.push_back({at, 0});
    lines_.item_of_source.push_back(items_++);
  }

  [[nodiscard]] Field field(Method method, FieldLimits limits = {}) {
    auto found =
        solve_from_lines(method, {}, surface_.adjacency(), sources_,
                         std::make_shared<const SourceLines>(lines_), limits, scratch_, cancel_);
    REQUIRE(found);
    return std::move(*found);
  }
  [[nodiscard]] double at(const Field& field, const SurfacePoint& point) const {
    const PointArrivals arrivals(surface_.adjacency(), field);
    const auto found = distance_at_point(surface_.adjacency(), field, arrivals, point, cancel_);
    REQUIRE(found);
    return *found;
  }
  [[nodiscard]] std::optional<Path> path(const Field& field, const SurfacePoint& to,
                                         PathWork work = PathWork::traced) const {
    auto found = path_from_lines(surface_.adjacency(), field, to, work, cancel_);
    REQUIRE(found);
    return std::move(*found);
  }
  [[nodiscard]] const std::vector<Source>& sources() const { return sources_; }
  [[nodiscard]] const SourceLines& lines() const { return lines_; }

 private:
  const Surface& surface_;
  Cancel cancel_;
  SourceLines lines_;
  std::vector<Source> sources_;
  SolveScratch scratch_;
  std::uint32_t items_ = 0;
};

// A point of some face, in its middle, on one of its sides or at a corner.
inline SurfacePoint some_point(const Surface& surface, std::mt19937& random) {
  const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
  const auto unit = [&] { return 0.01 + 0.98 * (random() / 4294967296.0); };
  std::array<double, 3> bary{unit(), unit(), unit()};
  if (random() % 4 == 0) bary[random() % 3] = 0;
  if (random() % 4 == 0)
    return point_at_vertex(surface.adjacency(), surface.adjacency().face(f).vertex[random() % 3]);
  return point_on_face(surface.adjacency(), f, bary);
}

// Lines of some kind, with points as dense as `spacing` on all of them.
struct DensePoints {
  std::vector<Source> sources;
  double spacing = 0;
};

inline DensePoints dense_points(const Surface& surface, const SourceLines& lines,
                                const std::vector<Source>& ends, int parts) {
  DensePoints dense{ends, 0};
  for (const LineSegment& segment : lines.segments) {
    const auto at = [&](double part) {
      std::array<double, 3> bary{};
      for (std::size_t c = 0; c < 3; ++c) {
        bary[c] = segment.from[c] + part * (segment.to[c] - segment.from[c]);
      }
      return point_on_face(surface.adjacency(), segment.face, bary);
    };
    for (int i = 1; i < parts; ++i) dense.sources.push_back({at(double(i) / parts), 0});
    dense.spacing = std::max(
        dense.spacing,
        norm(position_of(surface.mesh(), at(0)) - position_of(surface.mesh(), at(1))) / parts);
  }
  return dense;
}

inline void ask_some_lines(const Surface& surface, std::mt19937& random, LineQuestion& question) {
  const auto faces = static_cast<std::uint32_t>(surface.mesh().face_count());
  switch (random() % 4) {
    case 0:
      if (surface.adjacency().report().edges_boundary > 0) return question.boundary();
      [[fallthrough]];
    case 1: {
      std::vector<std::uint32_t> set;
      const std::uint32_t first = random() % faces;
      for (std::uint32_t f = first; f < std::min(faces, first + 1 + faces / 8); ++f) {
        set.push_back(f);
      }
      return question.faces(set);
    }
    default: {
      // Along a path between two places of one piece.
      const SurfacePoint from = some_point(surface, random);
      const Field field = surface.field_by(Method::exact, {Source{from, 0}});
      for (int tries = 0; tries < 50; ++tries) {
        const SurfacePoint to = some_point(surface, random);
        if (!surface.path(field, to)) continue;
        (void)question.curve({from, to}, random() % 2 == 0);
        return;
      }
      question.point(from);
    }
  }
}

inline double to_polyline(Vec3 p, const std::vector<Vec3>& line, bool is_closed) {
  double least = norm(p - line.front());
  for (std::size_t i = 0; i + 1 < line.size() + (is_closed ? 1 : 0); ++i) {
    least = std::min(least, to_segment(p, line[i], line[(i + 1) % line.size()]));
  }
  return least;
}

// A rectangle cut into random triangles, turned in space.
inline TriangleSoup turned_plane(std::uint32_t columns, std::uint32_t rows, std::mt19937& random) {
  TriangleSoup soup = shapes::plane(columns, rows);
  const auto unit = [&] { return random() / 4294967296.0 - 0.5; };
  const auto on_edge = [&](Vec3 p) {
    double least_x = 1e9, most_x = -1e9, least_y = 1e9, most_y = -1e9;
    for (const Vec3 q : soup.positions) {
      least_x = std::min(least_x, q.x), most_x = std::max(most_x, q.x);
      least_y = std::min(least_y, q.y), most_y = std::max(most_y, q.y);
    }
    return p.x == least_x || p.x == most_x || p.y == least_y || p.y == most_y;
  };
  std::vector<Vec3> moved = soup.positions;
  for (Vec3& p : moved) {
    if (!on_edge(p)) p = p + Vec3{0.5 * unit(), 0.5 * unit(), 0};
  }
  const double a = 6 * unit();
  const double b = 6 * unit();
  for (Vec3& p : moved) {
    const Vec3 q{std::cos(a) * p.x - std::sin(a) * p.y, std::sin(a) * p.x + std::cos(a) * p.y, 0};
    p = {q.x + 3, std::cos(b) * q.y - 1, std::sin(b) * q.y};
  }
  soup.positions = std::move(moved);
  return soup;
}

}  // namespace geodesic::fixtures
