#include "tests/bench/frontier_lines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/field/line_waves.h"
#include "core/mesh/cut_mesh.h"
#include "core/refine/cut_along.h"
#include "core/refine/line_sides.h"
#include "core/refine/refine_along.h"
#include "core/solve/curve_lines.h"
#include "core/solve/pair_search.h"
#include "core/solve/solve_from_lines.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {
namespace {

constexpr std::size_t kMostPieces = 1'000'000;

// The largest relative difference of what both fields reach.
double most_off(const Field& found, const Field& true_one) {
  double off = 0;
  for (std::size_t v = 0; v < true_one.distance.size(); ++v) {
    const double d = true_one.distance[v];
    if (d > 0 && d < kUnreached) off = std::max(off, std::abs(found.distance[v] / d - 1));
  }
  return off;
}

Figures from_a_curve_by(Method by, Asked& asked) {
  const Adjacency& adjacency = asked.adjacency();
  const std::vector<SurfacePoint> points = asked.connected_points(4);
  std::shared_ptr<SourceLines> lines;
  std::vector<Source> sources;
  const auto solve = [&](Method method) {
    FieldLimits limits;
    limits.keep_details = false;
    return take(
        solve_from_lines(method, {}, adjacency, sources, lines, limits, asked.scratch(), Cancel()));
  };
  Field found;
  Figures figures;
  figures.ms = processor_ms_of([&] {
    lines = std::make_shared<SourceLines>();
    sources.clear();
    (void)take(add_curve(adjacency, points, true, 0, kMostPieces, *lines, sources, asked.scratch(),
                         Cancel()));
    found = solve(by);
  });
  figures.off = most_off(found, solve(Method::exact));
  return figures;
}

}  // namespace

Figures from_a_curve(Asked& asked) { return from_a_curve_by(Method::back_traced, asked); }

Figures from_a_curve_by_wavefront(Asked& asked) {
  return from_a_curve_by(Method::wavefront, asked);
}

Figures in_a_region(Asked& asked) {
  const Mesh& whole = asked.adjacency().mesh();
  const Field field = asked.field(Method::exact, kUnreached, false);
  const Vec3 source = position_of(whole, asked.source().point);
  std::vector<std::uint8_t> is_left(whole.source_face_count(), 1);
  for (std::uint32_t f = 0; f < whole.face_count(); ++f) {
    const Triangle& face = whole.faces()[f];
    const double d = field.distance[face[0]] / asked.farthest();
    const bool is_beside = whole.positions()[face[0]].x < source.x;
    if (d > 0.4 && d < 0.5 && is_beside) is_left[whole.source_of_face(f)] = 0;
  }
  std::shared_ptr<const Adjacency> left;
  Field found;
  const auto solve = [&](Method method) {
    FieldLimits limits;
    limits.keep_details = false;
    const std::uint32_t source_vertex = whole.source_of_vertex(asked.source().point.vertex);
    const std::uint32_t v = left->mesh().vertex_of_source()[source_vertex];
    const Source from{point_at_vertex(*left, v), 0};
    return take(solve_field(method, {}, *left, {&from, 1}, limits, asked.scratch(), Cancel()));
  };
  Figures figures;
  figures.ms = processor_ms_of([&] {
    const auto mesh = std::make_shared<const Mesh>(take(cut_mesh(whole, is_left, Cancel())));
    left = std::make_shared<const Adjacency>(take(Adjacency::build(mesh, Cancel())));
    found = solve(Method::back_traced);
  });
  figures.off = most_off(found, solve(Method::exact));
  return figures;
}

Figures behind_a_wall(Asked& asked) {
  const Adjacency& whole = asked.adjacency();
  const std::vector<std::uint32_t> ends = asked.connected_vertices(7);
  const Source begin{point_at_vertex(whole, ends[3]), 0};
  const auto way =
      take(pair_search(Method::exact, {}, whole, begin, point_at_vertex(whole, ends[5]),
                       PairPath::refined, asked.scratch(), Cancel()));
  SurfacePolyline line;
  for (const PathPoint& point : way.path->points) line.push_back(point.point);
  std::shared_ptr<const Adjacency> walled;
  Field found;
  const auto solve = [&](Method method) {
    FieldLimits limits;
    limits.keep_details = false;
    const std::uint32_t source = whole.mesh().source_of_vertex(asked.source().point.vertex);
    const Source from{point_at_vertex(*walled, walled->mesh().vertex_of_source()[source]), 0};
    return take(solve_field(method, {}, *walled, {&from, 1}, limits, asked.scratch(), Cancel()));
  };
  Figures figures;
  figures.ms = processor_ms_of([&] {
    const Cancel never;
    Poll poll(never);
    const SurfacePolyline wall = as_wall(whole, line, poll);
    const RefinedMesh refined = take(refine_along(whole, std::span(&wall, 1), kMostPieces, never));
    const std::vector<std::uint8_t> is_left(refined.mesh.face_count(), 1);
    const std::uint32_t first = 0;
    CutMesh cut = take(cut_along(refined, {&first, 1}, is_left, never));
    const auto mesh = std::make_shared<const Mesh>(std::move(cut.mesh));
    walled = std::make_shared<const Adjacency>(take(Adjacency::build(mesh, never)));
    found = solve(Method::back_traced);
  });
  figures.off = most_off(found, solve(Method::exact));
  return figures;
}

Figures with_signs(Asked& asked) {
  const Adjacency& adjacency = asked.adjacency();
  const std::vector<SurfacePoint> points = asked.connected_points(4);
  const auto lines = std::make_shared<SourceLines>();
  std::vector<Source> sources;
  Result<LineSides> sides = fail(ErrorCode::value_out_of_range, "");
  Field field;
  Figures figures;
  figures.ms = processor_ms_of([&] {
    (void)take(add_curve(adjacency, points, true, 0, kMostPieces, *lines, sources, asked.scratch(),
                         Cancel()));
    SurfacePolyline round;
    for (const Source& source : sources) round.push_back(source.point);
    FieldLimits limits;
    limits.keep_details = false;
    sides = LineSides::find(adjacency, round, kMostPieces, Cancel());
    field = take(solve_from_lines(Method::back_traced, {}, adjacency, sources, lines, limits,
                                  asked.scratch(), Cancel()));
  });
  if (!sides) {
    figures.is_there = false;
    return figures;
  }
  std::size_t changes = 0;
  const Mesh& mesh = adjacency.mesh();
  for (const Triangle& face : mesh.faces()) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = face[c];
      const std::uint32_t b = face[(c + 1) % 3];
      // A line that crosses the edge is no farther from its ends than the edge is long.
      const double side = distance(mesh.positions()[a], mesh.positions()[b]);
      const bool is_away = field.distance[a] + field.distance[b] > side * (1 + 1e-3);
      if (is_away && sides->is_inside(a) != sides->is_inside(b)) ++changes;
    }
  }
  figures.off = static_cast<double>(changes) / (3.0 * mesh.face_count());
  return figures;
}

Figures tables(Asked& asked) {
  const Adjacency& adjacency = asked.adjacency();
  const std::vector<std::uint32_t> points = asked.connected_vertices(10);
  const auto rows = [&](Method method) {
    std::vector<double> entries;
    for (const std::uint32_t from : points) {
      FieldLimits limits;
      limits.targets = points;
      limits.keep_details = false;
      const Source source{point_at_vertex(adjacency, from), 0};
      const Field field =
          take(solve_field(method, {}, adjacency, {&source, 1}, limits, asked.scratch(), Cancel()));
      for (const std::uint32_t to : points) entries.push_back(field.distance[to]);
    }
    return entries;
  };
  std::vector<double> found;
  Figures figures;
  figures.ms = processor_ms_of([&] { found = rows(Method::back_traced); });
  const std::vector<double> true_ones = rows(Method::exact);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (true_ones[i] > 0)
      figures.off = std::max(figures.off, std::abs(found[i] / true_ones[i] - 1));
  }
  return figures;
}

}  // namespace geodesic::bench
