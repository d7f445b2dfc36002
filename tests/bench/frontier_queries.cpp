#include "tests/bench/frontier_queries.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/extent/extent.h"
#include "core/field/longest_edge.h"
#include "core/locate/plane_section.h"
#include "core/paths/discs.h"
#include "core/paths/join_paths.h"
#include "core/solve/solve_field.h"
#include "core/straighten/log_map.h"
#include "core/straighten/loop_straightness.h"
#include "core/straighten/straightest_geodesic.h"
#include "core/straighten/tighten_loop.h"
#include "core/voronoi/voronoi.h"
#include "tests/bench/edge_dijkstra.h"
#include "tests/bench/frontier_asked.h"
#include "tests/bench/frontier_costs.h"
#include "tests/bench/frontier_files.h"
#include "tests/bench/frontier_lines.h"
#include "tests/bench/frontier_measures.h"
#include "tests/bench/frontier_ways.h"
#include "tests/bench/prepared.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {
namespace {

constexpr std::uint64_t kMostSegments = 1'000'000;
constexpr double kLongMs = 100;

// Off by: areas, from those that distances by `exact` give.
Figures discs(Asked& asked) {
  constexpr std::size_t kRadii = 16;
  std::vector<double> radii;
  for (std::size_t i = 1; i <= kRadii; ++i) {
    radii.push_back(asked.farthest() * static_cast<double>(i) / kRadii);
  }
  const auto measure = [&](Method method) {
    return take(
        measure_discs(asked.adjacency(), asked.field(method, kUnreached, false), radii, Cancel()));
  };
  Discs found;
  Figures figures;
  figures.ms = processor_ms_of([&] { found = measure(Method::back_traced); });
  const Discs true_ones = measure(Method::exact);
  for (std::size_t i = 0; i < kRadii; ++i) {
    const double area = true_ones.discs[i].area;
    if (area > 0) figures.off = std::max(figures.off, std::abs(found.discs[i].area / area - 1));
  }
  return figures;
}

// Off by: where one comes straight ahead by a vertex's direction and distance, of the radius.
Figures log_maps(Asked& asked) {
  constexpr std::size_t kTried = 500;
  const Adjacency& adjacency = asked.adjacency();
  const SurfacePoint& from = asked.source().point;
  const double radius = 0.1 * asked.farthest();
  const double max = kFieldBeyondRadius * radius + 2 * longest_edge(adjacency);
  LogMap map;
  Figures figures;
  figures.ms = processor_ms_of([&] {
    const Field field = asked.field(Method::back_traced, max, true);
    map = take(log_map(adjacency, field, from, radius, Cancel()));
  });
  const std::size_t step = map.entries.size() / kTried + 1;
  for (std::size_t i = 0; i < map.entries.size(); i += step) {
    const LogMap::Entry& entry = map.entries[i];
    if (!entry.is_straight) continue;
    const StraightestGeodesic way =
        take(straightest_geodesic_at_angle(adjacency, from, entry.angle, entry.distance, Cancel()));
    const double miss =
        distance(way.path.points.back().position, adjacency.mesh().positions()[entry.vertex]);
    figures.off = std::max(figures.off, miss / radius);
  }
  return figures;
}

// Off by: how much longer it may be than what was found, by the bounds.
Figures diameters(Asked& asked) {
  constexpr std::uint64_t kFields = 20;
  Extent found;
  Figures figures;
  figures.ms = processor_ms_of([&] {
    found = take(extent(ExtentOf::diameter, Method::back_traced, {}, asked.adjacency(), kFields,
                        asked.scratch(), Cancel()));
  });
  figures.off = found.upper / found.value - 1;
  return figures;
}

// Off by: the surface that other sites have than by `exact`, of all of it.
Figures cells(Asked& asked) {
  constexpr std::uint32_t kSites = 100;
  const Adjacency& adjacency = asked.adjacency();
  std::vector<Source> sites;
  for (std::uint32_t i = 0; i < kSites; ++i) {
    const auto face =
        static_cast<std::uint32_t>(std::uint64_t{i} * adjacency.faces().size() / kSites);
    sites.push_back({point_on_face(adjacency, face, {1, 1, 1}), 0});
  }
  const auto divide = [&](Method method) {
    FieldLimits limits;
    limits.keep_details = false;
    const Field field =
        take(solve_field(method, {}, adjacency, sites, limits, asked.scratch(), Cancel()));
    return take(voronoi(method, {}, adjacency, field, kMostSegments, asked.scratch(), Cancel()));
  };
  Voronoi found;
  Figures figures;
  figures.ms = processor_ms_of([&] { found = divide(Method::back_traced); });
  const Voronoi true_one = divide(Method::exact);
  double all = 0;
  for (std::uint32_t i = 0; i < kSites; ++i) {
    figures.off += std::abs(found.cells[i].area - true_one.cells[i].area) / 2;
    all += true_one.cells[i].area;
  }
  figures.off /= all;
  return figures;
}

// Off by: how far the loop is off straight ahead, of a half turn. Nothing where it contracts, where
// the plane cuts no loop, or where it passes faces without area.
Figures loops(Asked& asked) {
  const Adjacency& adjacency = asked.adjacency();
  Figures figures;
  Result<TightLoop> tight = fail(ErrorCode::no_loop, "");
  figures.ms = processor_ms_of([&] {
    const auto section = plane_section(adjacency, asked.source().point, {1, 0.3, 0.2}, Cancel());
    if (section) {
      tight = tighten_loop(adjacency, closed_path_along(adjacency.mesh(), *section), Cancel());
    }
  });
  figures.is_there = tight.has_value();
  if (tight) {
    const LoopStraightness found = take(straightness_of_loop(adjacency, tight->path, Cancel()));
    figures.is_there = found.is_known;
    figures.off = found.turn / std::numbers::pi;
  }
  return figures;
}

}  // namespace

void print_queries(std::uint32_t seed, const std::vector<std::string>& files) {
  using Query = Figures (*)(Asked&);
  const std::array<std::pair<const char*, Query>, 26> queries{{
      {"20 paths, refined | the longest beside the shortest by `exact`", refined_paths},
      {"10 isolines | their length, against `exact`", level_lines},
      {"a table of 10 x 10 points | distances, against `exact`", tables},
      {"16 discs | areas, against `exact`", discs},
      {"the diameter by 20 fields | its bounds", diameters},
      {"the mean distance by 20 fields | against `exact` from the same vertices", mean_distance},
      {"the mean distance of each vertex by 20 fields | against `exact` from the same vertices",
       means_of_vertices},
      {"strips between 11 levels | areas, against `exact`, of the surface", strips},
      {"30 samples | how far they cover, against `exact`", samples},
      {"the cells of 100 sites | what other sites have than by `exact`", cells},
      {"10 rounds of Lloyd for 20 sites | from the centroids, of a cell's size", relaxed_sites},
      {"a log map to a tenth of the farthest | going there straight, of the radius", log_maps},
      {"the same with a direction carried along | angles to the paths, of a half turn",
       carried_directions},
      {"20 traces as long as the farthest is away | there and back, of the way", traces},
      {"a plane's section, tightened | straight ahead, of a half turn", loops},
      {"its hull, as a tape lies | what sticks out, of its length", hulls},
      {"1,000 nearest points | against the other hierarchy, of the farthest", nearest_points},
      {"a closed curve through 4 points as source | distances, against `exact`", from_a_curve},
      {"the same with signs | signs that change away from it, of all edges", with_signs},
      {"what such a curve has inside | its area, backwards", inside_of_a_curve},
      {"such a curve as source, by `wavefront` | distances, against `exact`",
       from_a_curve_by_wavefront},
      {"a field past a forbidden region | distances, against `exact`", in_a_region},
      {"a field past a wall | distances, against `exact`", behind_a_wall},
      {"a field of costs, one side three times as dear | the mean, against 7 points an edge",
       by_weights},
      {"a field of costs by slopes | the mean, against 7 points an edge", by_slopes},
      {"a field written back into its file | what is read there, against the field",
       annotated_files},
  }};
  std::printf(
      "\n### 12. Queries that follow from fields\n\nBy `auto`, costs by `steiner`, their fields "
      "included. Meshes drawn by `--queries --seed %u`.\n\n"
      "| mesh | query | off by | at the most | y |\n|---|---|---|--:|--:|\n",
      seed);
  std::vector<FrontierMesh> meshes = drawn_meshes(seed);
  for (FrontierMesh& mesh : meshes_of(files)) meshes.push_back(std::move(mesh));
  for (const FrontierMesh& mesh : meshes) {
    if (mesh.large) continue;
    const Prepared prepared(mesh.soup);
    Asked asked(prepared, mesh);
    Yardstick yardstick(prepared.adjacency());
    for (const auto& [title, query] : queries) {
      Figures figures = query(asked);
      // Once more, for what the memory it works in has cost; of what takes long that is little.
      if (figures.ms < kLongMs) figures = query(asked);
      const double y = yardstick.ms(prepared.vertex(mesh.first_source));
      std::printf("| %s | %s | ", mesh.title.c_str(), title);
      if (figures.is_there) {
        std::printf("%.2g %%", 100 * figures.off);
      } else {
        std::printf("none here");
      }
      std::printf(" | %.1f |\n", figures.ms / y);
      std::fflush(stdout);
    }
  }
}

}  // namespace geodesic::bench
