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
#include "core/field/line_waves.h"
#include "core/field/travel_cost.h"
#include "core/locate/plane_section.h"
#include "core/mesh/cut_mesh.h"
#include "core/paths/discs.h"
#include "core/paths/join_paths.h"
#include "core/solve/curve_lines.h"
#include "core/solve/solve_field.h"
#include "core/solve/solve_from_lines.h"
#include "core/steiner/steiner.h"
#include "core/straighten/log_map.h"
#include "core/straighten/loop_straightness.h"
#include "core/straighten/straightest_geodesic.h"
#include "core/straighten/tighten_loop.h"
#include "core/surface/longest_edge.h"
#include "core/voronoi/voronoi.h"
#include "tests/bench/edge_dijkstra.h"
#include "tests/bench/prepared.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {
namespace {

constexpr std::uint64_t kMostSegments = 1'000'000;

template <class Value>
Value take(Result<Value> result) {
  if (!result) give_up(result.error().detail);
  return std::move(*result);
}

struct Figures {
  double ms = 0;
  double off = 0;  // relative
};

// The mesh of a row, and what all queries need of it.
class Asked {
 public:
  Asked(const Prepared& prepared, const FrontierMesh& mesh)
      : prepared_(prepared), source_(prepared.source_at(mesh.first_source)) {
    for (const double d : field(Method::exact, kUnreached, false).distance.values()) {
      if (d < kUnreached) farthest_ = std::max(farthest_, d);
    }
  }

  [[nodiscard]] const Adjacency& adjacency() const { return prepared_.adjacency(); }
  [[nodiscard]] const Source& source() const { return source_; }
  [[nodiscard]] double farthest() const { return farthest_; }
  [[nodiscard]] SolveScratch& scratch() { return scratch_; }

  [[nodiscard]] Field field(Method method, double max, bool keep_details) {
    FieldLimits limits;
    limits.max = max;
    limits.keep_details = keep_details;
    return take(solve_field(method, {}, adjacency(), {&source_, 1}, limits, scratch_, Cancel()));
  }

 private:
  const Prepared& prepared_;
  Source source_;
  double farthest_ = 0;
  SolveScratch scratch_;
};

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

// Off by: how far the loop is off straight ahead, of a half turn. Nothing where it contracts.
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
  if (tight) {
    figures.off =
        take(straightness_of_loop(adjacency, tight->path, Cancel())).turn / std::numbers::pi;
  }
  return figures;
}

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

// Off by: distances, at the most, from those by `exact` from the same lines.
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

// What is between two distances from the source is forbidden, but for one side of it. Off by:
// distances, at the most, from those by `exact` on what is left.
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

// One side costs three times as much. Off by: the mean above what more than twice as many points
// on edges find, for nothing finds the least.
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

// Off by: the largest difference of an entry from that by `exact`.
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

}  // namespace

void print_queries(std::span<const FrontierMesh> meshes) {
  using Query = Figures (*)(Asked&);
  const std::array<std::pair<const char*, Query>, 9> queries{{
      {"16 discs | areas, against `exact`", discs},
      {"a log map to a tenth of the farthest | going there straight, of the radius", log_maps},
      {"the diameter by 20 fields | its bounds", diameters},
      {"the cells of 100 sites | what other sites have than by `exact`", cells},
      {"a plane's section, tightened | straight ahead, of a half turn", loops},
      {"a closed curve through 4 points as source | distances, against `exact`", from_a_curve},
      {"a field past a forbidden region | distances, against `exact`", in_a_region},
      {"a field of costs, one side three times as dear | the mean, against 7 points an edge",
       by_weights},
      {"a table of 10 x 10 points | distances, against `exact`", tables},
  }};
  std::puts(
      "\n### 12. Queries that follow from fields\n\nBy `auto`, costs by `steiner`, their fields "
      "included.\n\n"
      "| mesh | query | off by | at the most | y |\n|---|---|---|--:|--:|");
  for (const FrontierMesh& mesh : meshes) {
    if (mesh.large) continue;
    const Prepared prepared(mesh.soup);
    Asked asked(prepared, mesh);
    Yardstick yardstick(prepared.adjacency());
    for (const auto& [title, query] : queries) {
      (void)query(asked);  // once for what the memory it works in costs
      const double y = yardstick.ms(prepared.vertex(mesh.first_source));
      const Figures figures = query(asked);
      std::printf("| %s | %s | %.2g %% | %.1f |\n", mesh.title.c_str(), title, 100 * figures.off,
                  figures.ms / y);
      std::fflush(stdout);
    }
  }
}

}  // namespace geodesic::bench
