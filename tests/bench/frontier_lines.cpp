#include "tests/bench/frontier_lines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/field/line_waves.h"
#include "core/field/travel_cost.h"
#include "core/mesh/cut_mesh.h"
#include "core/solve/curve_lines.h"
#include "core/solve/solve_from_lines.h"
#include "core/steiner/steiner.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {
namespace {

// The largest relative difference of what both fields reach.
double most_off(const Field& found, const Field& true_one) {
  double off = 0;
  for (std::size_t v = 0; v < true_one.distance.size(); ++v) {
    const double d = true_one.distance[v];
    if (d > 0 && d < kUnreached) off = std::max(off, std::abs(found.distance[v] / d - 1));
  }
  return off;
}

// Vertices with a way between them: from the nearest to the source on, evenly by their numbers.
std::vector<std::uint32_t> connected_vertices(Asked& asked, std::size_t count) {
  const Field field = asked.field(Method::back_traced, kUnreached, false);
  std::vector<std::uint32_t> reached;
  for (std::uint32_t v = 0; v < field.distance.size(); ++v) {
    if (field.distance[v] < kUnreached) reached.push_back(v);
  }
  std::vector<std::uint32_t> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(reached[i * reached.size() / count]);
  return chosen;
}

}  // namespace

Figures from_a_curve(Asked& asked) {
  constexpr std::size_t kMostPieces = 1'000'000;
  const Adjacency& adjacency = asked.adjacency();
  std::vector<SurfacePoint> points;
  for (const std::uint32_t v : connected_vertices(asked, 4)) {
    points.push_back(point_at_vertex(adjacency, v));
  }
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
    found = solve(Method::back_traced);
  });
  figures.off = most_off(found, solve(Method::exact));
  return figures;
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

Figures by_weights(Asked& asked) {
  constexpr std::uint32_t kFiner = 2 * MethodOptions{}.points_per_edge + 1;
  const Adjacency& adjacency = asked.adjacency();
  const Mesh& mesh = adjacency.mesh();
  const Vec3 source = position_of(mesh, asked.source().point);
  TravelCost::Parts parts;
  for (const Triangle& face : mesh.faces()) {
    parts.weights.push_back(mesh.positions()[face[0]].x < source.x ? 3 : 1);
  }
  const auto cost = std::make_shared<const TravelCost>(std::move(parts));
  WavefrontScratch scratch;
  const auto solve = [&](std::uint32_t points_per_edge) {
    FieldLimits limits;
    limits.keep_details = false;
    return take(steiner_field(adjacency, {&asked.source(), 1}, points_per_edge, limits, scratch,
                              Cancel(), cost));
  };
  Field found;
  Figures figures;
  figures.ms = processor_ms_of([&] { found = solve(MethodOptions{}.points_per_edge); });
  const Field finer = solve(kFiner);
  std::size_t compared = 0;
  for (std::size_t v = 0; v < finer.distance.size(); ++v) {
    const double d = finer.distance[v];
    if (!(d > 0 && d < kUnreached)) continue;
    figures.off += found.distance[v] / d - 1;
    ++compared;
  }
  if (compared > 0) figures.off /= static_cast<double>(compared);
  return figures;
}

Figures tables(Asked& asked) {
  const Adjacency& adjacency = asked.adjacency();
  const std::vector<std::uint32_t> points = connected_vertices(asked, 10);
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
