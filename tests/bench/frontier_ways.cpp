#include "tests/bench/frontier_ways.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/extent/extent.h"
#include "core/locate/closest_point.h"
#include "core/paths/isolines.h"
#include "core/solve/farthest_points.h"
#include "core/solve/pair_search.h"
#include "core/straighten/straightest_geodesic.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {

Figures refined_paths(Asked& asked) {
  constexpr std::size_t kPaths = 20;
  const Adjacency& adjacency = asked.adjacency();
  const std::vector<std::uint32_t> targets = asked.connected_vertices(kPaths);
  std::vector<double> lengths;
  Figures figures;
  figures.ms = processor_ms_of([&] {
    for (const std::uint32_t v : targets) {
      const Pair pair = take(pair_search(Method::back_traced, {}, adjacency, asked.source(),
                                         point_at_vertex(adjacency, v), PairPath::refined,
                                         asked.scratch(), Cancel()));
      lengths.push_back(pair.path ? pair.path->length : 0);
    }
  });
  const Field shortest = asked.field(Method::exact, kUnreached, false);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const double d = shortest.distance[targets[i]];
    if (d > 0) figures.off = std::max(figures.off, lengths[i] / d - 1);
  }
  return figures;
}

Figures level_lines(Asked& asked) {
  constexpr std::size_t kLevels = 10;
  constexpr std::uint64_t kMostSegments = 10'000'000;
  std::vector<double> levels;
  for (std::size_t i = 1; i <= kLevels; ++i) {
    levels.push_back(asked.farthest() * static_cast<double>(i) / (kLevels + 1));
  }
  const auto length = [&](Method method) {
    const Field field = asked.field(method, kUnreached, false);
    double sum = 0;
    for (const Isoline& line :
         take(isolines(asked.adjacency(), field, levels, kMostSegments, Cancel()))) {
      sum += line.length;
    }
    return sum;
  };
  double found = 0;
  Figures figures;
  figures.ms = processor_ms_of([&] { found = length(Method::back_traced); });
  figures.off = std::abs(found / length(Method::exact) - 1);
  return figures;
}

Figures samples(Asked& asked) {
  constexpr std::size_t kSamples = 30;
  const Adjacency& adjacency = asked.adjacency();
  FarthestPoints found;
  Figures figures;
  figures.ms = processor_ms_of([&] {
    found = take(farthest_points(Method::back_traced, {}, adjacency, {}, kSamples, asked.scratch(),
                                 Cancel()));
  });
  std::vector<Source> sources;
  for (const FarthestPoint& point : found.points) {
    sources.push_back({point_at_vertex(adjacency, point.vertex), 0});
  }
  FieldLimits limits;
  limits.keep_details = false;
  const Field field =
      take(solve_field(Method::exact, {}, adjacency, sources, limits, asked.scratch(), Cancel()));
  double radius = 0;
  for (std::uint32_t v = 0; v < field.distance.size(); ++v) {
    if (!adjacency.corners(v).empty()) radius = std::max(radius, double{field.distance[v]});
  }
  // More parts than samples: neither covers all.
  if (radius < kUnreached) figures.off = std::abs(found.covering_radius / radius - 1);
  return figures;
}

Figures traces(Asked& asked) {
  constexpr std::size_t kTraces = 20;
  const Adjacency& adjacency = asked.adjacency();
  std::vector<SurfacePoint> starts;
  std::vector<StraightestGeodesic> there;
  for (std::size_t i = 0; i < kTraces; ++i) {
    const std::size_t face = i * adjacency.faces().size() / kTraces;
    starts.push_back(point_on_face(adjacency, static_cast<std::uint32_t>(face), {1, 1, 1}));
  }
  Figures figures;
  figures.ms = processor_ms_of([&] {
    for (std::size_t i = 0; i < kTraces; ++i) {
      there.push_back(take(straightest_geodesic_at_angle(
          adjacency, starts[i], static_cast<double>(i), asked.farthest(), Cancel())));
    }
  });
  for (std::size_t i = 0; i < kTraces; ++i) {
    // From an edge or a vertex the way back may be by another face.
    if (there[i].end != StraightestGeodesic::End::length) continue;
    const double length = there[i].path.length;
    if (!(length > 0)) continue;
    const StraightestGeodesic back =
        take(straightest_geodesic(adjacency, there[i].path.points.back().point,
                                  -1.0 * there[i].direction_at_end, length, Cancel()));
    const double miss =
        distance(back.path.points.back().position, position_of(adjacency.mesh(), starts[i]));
    figures.off = std::max(figures.off, miss / length);
  }
  return figures;
}

Figures nearest_points(Asked& asked) {
  constexpr std::size_t kPoints = 1000;
  const Mesh& mesh = asked.adjacency().mesh();
  const auto adjacency = std::make_shared<const Adjacency>(asked.adjacency());
  const auto index = take(ClosestPointIndex::build(adjacency, Cancel()));
  const auto other =
      take(ClosestPointIndex::build(adjacency, Cancel(), ClosestPointIndex::Hierarchy::boxes));
  std::mt19937 random(11);
  std::vector<Vec3> from;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const auto unit = [&] { return random() / 4294967296.0 - 0.5; };
    const Vec3 near = mesh.positions()[random() % mesh.vertex_count()];
    from.push_back(near + 0.2 * asked.farthest() * Vec3{unit(), unit(), unit()});
  }
  std::vector<double> found;
  Figures figures;
  figures.ms = processor_ms_of([&] {
    for (const Vec3& p : from) found.push_back(index->closest(p).distance);
  });
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double off = std::abs(found[i] - other->closest(from[i]).distance) / asked.farthest();
    figures.off = std::max(figures.off, off);
  }
  return figures;
}

Figures mean_distance(Asked& asked) {
  constexpr std::uint64_t kFields = 20;
  const auto mean = [&](Method method) {
    return take(extent(ExtentOf::mean, method, {}, asked.adjacency(), kFields, asked.scratch(),
                       Cancel()))
        .value;
  };
  double found = 0;
  Figures figures;
  figures.ms = processor_ms_of([&] { found = mean(Method::back_traced); });
  figures.off = std::abs(found / mean(Method::exact) - 1);
  return figures;
}

}  // namespace geodesic::bench
