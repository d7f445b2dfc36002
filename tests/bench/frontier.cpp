#include "tests/bench/frontier.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/back_traced/trace_lanes.h"
#include "core/paths/trace_path.h"
#include "core/straighten/refine_path.h"
#include "tests/bench/edge_dijkstra.h"
#include "tests/bench/errors.h"
#include "tests/bench/frontier_meshes.h"
#include "tests/bench/frontier_pairs.h"
#include "tests/bench/frontier_queries.h"
#include "tests/bench/frontier_sources.h"
#include "tests/bench/frontier_threads.h"
#include "tests/bench/peak_memory.h"
#include "tests/bench/prepared.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {
namespace {

constexpr std::size_t kRounds = 7;
constexpr double kMostOfWavefront = 1.2;  // times of the yardstick
constexpr double kMostBytesPerVertex = 200;
constexpr double kRightBelow = 1e-9;  // of an upper bound, below the true distance

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

const char* verdict(bool reached) { return reached ? "yes" : "**no**"; }

// A vertex in a face each, that of the source vertex first.
std::vector<std::uint32_t> vertices_of(const Prepared& prepared, std::uint32_t first,
                                       std::size_t count) {
  std::mt19937 random(7);
  std::vector<std::uint32_t> vertices{prepared.vertex(first)};
  while (vertices.size() < count) {
    const auto v = static_cast<std::uint32_t>(random() % prepared.mesh().vertex_count());
    if (!prepared.adjacency().corners(v).empty()) vertices.push_back(v);
  }
  return vertices;
}

class Solver {
 public:
  Solver(Method method, Bound bound) : method_(method) { options_.bound = bound; }
  explicit Solver(double tolerance) : method_(Method::back_traced) {
    options_.error_at_most = tolerance;
  }

  Field operator()(const Prepared& prepared, std::uint32_t vertex, bool keep_details = false) {
    const Source source{point_at_vertex(prepared.adjacency(), vertex), 0};
    FieldLimits limits;
    limits.keep_details = keep_details;
    auto field = solve_field(method_, options_, prepared.adjacency(), {&source, 1}, limits,
                             scratch_, Cancel());
    if (!field) give_up(field.error().detail);
    return std::move(*field);
  }

 private:
  Method method_;
  MethodOptions options_;
  SolveScratch scratch_;
};

// Of one way to a field: its time in yardsticks and its errors over all sources.
struct Measured {
  double over_yardstick = 0;
  double mean = 0;
  double p999 = 0;
  double max = 0;
  double lowest = 0;  // the most below the true distance, not positive
};

void add_errors(const Field& field, std::span<const double> truth, std::size_t sources,
                Measured& sum) {
  const Errors errors = errors_of(field.distance.values(), truth);
  if (errors.unreached + errors.invented != 0) give_up("a vertex is reached by one method only");
  sum.mean += errors.mean / static_cast<double>(sources);
  sum.p999 = std::max(sum.p999, errors.p999);
  sum.max = std::max(sum.max, errors.max);
  for (std::size_t v = 0; v < truth.size(); ++v) {
    if (!(truth[v] > 0) || !std::isfinite(truth[v])) continue;
    sum.lowest = std::min(sum.lowest, field.distance[v] / truth[v] - 1);
  }
}

// Row 3: what is asked for, and what it may cost.
struct Tolerance {
  double part;
  double of_exact;  // of exact's time; 0: no aim
};
constexpr std::array<Tolerance, 5> kTolerances{
    {{1e-2, 1.0 / 3}, {1e-3, 0.5}, {1e-4, 0}, {1e-5, 0}, {1e-6, 0}}};

struct MeshRow {
  Measured automatic, upper, exact;
  double dijkstra = 0;   // times of the yardstick
  double wavefront = 0;  // likewise
  std::array<Measured, kTolerances.size()> within;
  std::size_t exact_bytes = 0;  // that `exact` held at once, its result included
  double prepare_over_yardstick = 0;
  double bytes_per_vertex = 0;  // of the mesh, prepared
  double yardstick_ms = 0;
  double automatic_ms = 0;
};

MeshRow measure(const FrontierMesh& mesh, std::size_t source_count) {
  MeshRow row;
  const double begun = processor_ms();
  const Prepared prepared(mesh.soup);
  const double prepare_ms = processor_ms() - begun;
  row.bytes_per_vertex =
      static_cast<double>(prepared.mesh().bytes() + prepared.adjacency().bytes()) /
      static_cast<double>(prepared.mesh().vertex_count());
  Solver dijkstra(Method::dijkstra, Bound::none);
  Solver wavefront(Method::wavefront, Bound::none);
  Solver automatic(Method::back_traced, Bound::none);
  Solver upper(Method::back_traced, Bound::upper);
  Solver exact(Method::exact, Bound::none);
  const auto sources = vertices_of(prepared, mesh.first_source, source_count);
  std::vector<double> exact_ms;
  std::array<std::vector<double>, kTolerances.size()> within_ms;
  std::vector<Solver> within;
  for (const Tolerance& tolerance : kTolerances) within.emplace_back(tolerance.part);
  for (const std::uint32_t source : sources) {
    std::optional<Field> truth;
    const double start = processor_ms();
    const std::size_t bytes = peak_bytes_of([&] { truth = exact(prepared, source); });
    exact_ms.push_back(processor_ms() - start);
    row.exact_bytes = std::max(row.exact_bytes, bytes);
    add_errors(automatic(prepared, source), truth->distance.values(), sources.size(),
               row.automatic);
    add_errors(upper(prepared, source), truth->distance.values(), sources.size(), row.upper);
    for (std::size_t i = 0; i < kTolerances.size(); ++i) {
      std::optional<Field> field;
      within_ms[i].push_back(processor_ms_of([&] { field = within[i](prepared, source); }));
      add_errors(*field, truth->distance.values(), sources.size(), row.within[i]);
    }
  }
  // One after the other, so that a machine that slows down does so for all alike.
  Yardstick yardstick(prepared.adjacency());
  std::vector<double> by_auto;
  std::vector<double> by_upper;
  std::vector<double> by_dijkstra;
  std::vector<double> by_wavefront;
  std::vector<double> yardstick_ms;
  std::vector<double> automatic_ms;
  for (std::size_t round = 0; round < kRounds; ++round) {
    const std::uint32_t source = sources[round % sources.size()];
    const double y = yardstick.ms(source);
    const double a = processor_ms_of([&] { (void)automatic(prepared, source); });
    const double u = processor_ms_of([&] { (void)upper(prepared, source); });
    by_dijkstra.push_back(processor_ms_of([&] { (void)dijkstra(prepared, source); }) / y);
    by_wavefront.push_back(processor_ms_of([&] { (void)wavefront(prepared, source); }) / y);
    yardstick_ms.push_back(y);
    automatic_ms.push_back(a);
    by_auto.push_back(a / y);
    by_upper.push_back(u / y);
  }
  row.yardstick_ms = median(yardstick_ms);
  row.automatic_ms = median(automatic_ms);
  row.automatic.over_yardstick = median(by_auto);
  row.upper.over_yardstick = median(by_upper);
  row.dijkstra = median(by_dijkstra);
  row.wavefront = median(by_wavefront);
  row.exact.over_yardstick = median(exact_ms) / row.yardstick_ms;
  for (std::size_t i = 0; i < kTolerances.size(); ++i) {
    row.within[i].over_yardstick = median(within_ms[i]) / row.yardstick_ms;
  }
  row.prepare_over_yardstick = prepare_ms / row.yardstick_ms;
  return row;
}

void print_default(const FrontierMesh& mesh, const MeshRow& row) {
  const Measured& m = row.automatic;
  const Aim& aim = mesh.aim;
  const auto error = [](double is, double most) {
    char cells[64];
    if (std::isfinite(most)) {
      std::snprintf(cells, sizeof cells, "%.4f %% | %.2f %% | %s", 100 * is, 100 * most,
                    verdict(is <= most));
    } else {
      std::snprintf(cells, sizeof cells, "%.4f %% | | ", 100 * is);
    }
    return std::string(cells);
  };
  std::printf("| %s | %s | %s | %s | %.2f | %.1f | %s | %.2f | %s | %.2f | %s |\n",
              mesh.title.c_str(), error(m.mean, aim.mean).c_str(), error(m.p999, aim.p999).c_str(),
              error(m.max, aim.max).c_str(), m.over_yardstick, aim.over_yardstick,
              verdict(m.over_yardstick <= aim.over_yardstick), row.wavefront,
              verdict(row.wavefront <= kMostOfWavefront), row.dijkstra, verdict(row.dijkstra <= 1));
  std::fflush(stdout);
}

void print_upper(const FrontierMesh& mesh, const MeshRow& row) {
  const Measured& m = row.upper;
  std::printf("| %s | %.4f %% | %s | %.2f | %s | %.0e | %s |\n", mesh.title.c_str(), 100 * m.mean,
              verdict(m.mean <= 0.00016), m.over_yardstick,
              verdict(m.over_yardstick <= mesh.aim.upper), -m.lowest,
              verdict(-m.lowest <= kRightBelow));
}

void print_within(const FrontierMesh& mesh, const MeshRow& row) {
  std::printf("| %s ", mesh.title.c_str());
  bool kept = true;
  for (std::size_t i = 0; i < kTolerances.size(); ++i) {
    const Measured& m = row.within[i];
    kept = kept && m.max <= kTolerances[i].part + kRightBelow && -m.lowest <= kRightBelow;
    const double of_exact = m.over_yardstick / row.exact.over_yardstick;
    const double aim = kTolerances[i].of_exact;
    const char* reached = aim == 0 ? "" : verdict(of_exact <= aim);
    std::printf("| %.2f / %.0e / %.1e %s ", of_exact, m.mean, m.max, reached);
  }
  std::printf("| %s |\n", verdict(kept));
}

void print_exact(const FrontierMesh& mesh, const MeshRow& row) {
  constexpr double kAtMostMegabytes = 400;
  const double megabytes = static_cast<double>(row.exact_bytes) / 1e6;
  std::printf("| %s | %.1f | %.0f | %s | %.1f | %s | %.1f | %s | %.0f | %s |\n", mesh.title.c_str(),
              row.exact.over_yardstick, mesh.aim.exact,
              verdict(row.exact.over_yardstick <= mesh.aim.exact), megabytes,
              mesh.large ? verdict(megabytes < kAtMostMegabytes) : "", row.prepare_over_yardstick,
              verdict(row.prepare_over_yardstick <= 6), row.bytes_per_vertex,
              verdict(row.bytes_per_vertex <= kMostBytesPerVertex));
}

// Row 7: paths by the default's field against the exact distances.
void print_paths(const FrontierMesh& mesh, std::size_t sources, std::size_t targets) {
  const Prepared prepared(mesh.soup);
  Solver automatic(Method::back_traced, Bound::none);
  Solver exact(Method::exact, Bound::none);
  const auto vertices = vertices_of(prepared, mesh.first_source, sources * (targets + 1));
  double longer = 0;
  std::size_t much_longer = 0;
  std::size_t pairs = 0;
  std::vector<double> ms;
  for (std::size_t s = 0; s < sources; ++s) {
    const std::uint32_t source = vertices[s];
    const Field truth = exact(prepared, source);
    const Field field = automatic(prepared, source);
    for (std::size_t t = 0; t < targets; ++t) {
      const std::uint32_t target = vertices[sources + s * targets + t];
      if (!(truth.distance[target] > 0) || truth.distance[target] == kUnreached) continue;
      std::optional<Path> path;
      ms.push_back(processor_ms_of([&] {
        auto traced = trace_path(prepared.adjacency(), field,
                                 point_at_vertex(prepared.adjacency(), target), Cancel());
        if (!traced || !*traced) give_up("no path where there is a distance");
        path = std::move(*traced);
        auto refined = refine_path(prepared.adjacency(), field,
                                   point_at_vertex(prepared.adjacency(), target), *path, Cancel());
        if (!refined) give_up(refined.error().detail);
        path = std::move(*refined);
      }));
      const double off = path->length / truth.distance[target] - 1;
      longer += off;
      if (off > 1e-3) ++much_longer;
      ++pairs;
    }
  }
  const auto count = static_cast<double>(pairs);
  const double share = static_cast<double>(much_longer) / count;
  std::printf("| %s | %zu | %.4f %% | %s | %.2f %% | %s | %.3f | %s |\n", mesh.title.c_str(), pairs,
              100 * longer / count, verdict(longer / count <= 5e-5), 100 * share,
              verdict(share < 0.01), median(ms), verdict(median(ms) < 0.3));
  std::fflush(stdout);
}

// Row 9: the same traces with each kind of instructions that this processor has.
void print_vectors() {
  const Prepared prepared(shapes::icosphere(6));
  Solver exact(Method::exact, Bound::none);
  const std::vector<double> distance = exact(prepared, 0).distance.values();
  const Triangulation faces = prepared.adjacency().delaunay();
  std::vector<TraceLanes> batches;
  for (std::uint32_t f = 0; f < faces.faces.size(); ++f) {
    if (f % TraceLanes::kLanes == 0) batches.emplace_back();
    const FaceRecord& face = faces.faces[f];
    std::uint32_t c = 0;  // the farthest corner, as a front has it
    for (std::uint32_t i = 1; i < 3; ++i) {
      if (distance[face.vertex[i]] > distance[face.vertex[c]]) c = i;
    }
    batches.back().add(halfedge(f, next_corner(c)), 0.5, kUnreached);
  }
  const auto ns = [&](Vectors vectors) {
    std::vector<double> ms;
    for (std::size_t round = 0; round < kRounds; ++round) {
      ms.push_back(processor_ms_of([&] {
        for (TraceLanes batch : batches) {
          trace_lanes(faces, FrontDistances(distance), {BackTrace::Candidates::virtual_sources},
                      vectors, batch);
        }
      }));
    }
    return 1e6 * median(ms) / static_cast<double>(faces.faces.size());
  };
  const double plain = ns(Vectors::plain);
  const double best = ns(best_vectors());
  const bool has_avx512 = best_vectors() == Vectors::avx512;
  const char* name = has_avx512 ? "AVX-512" : best_vectors() == Vectors::avx2 ? "AVX2" : "none";
  std::printf(
      "\n### 9. Lanes\n\nA trace takes %.0f ns with this processor's vectors (%s), %.0f ns with "
      "its "
      "plain ones: %.2f times, at most 2.5: %s. Results have the same bits (core_tests).\n",
      best, name, plain, plain / best, verdict(plain <= 2.5 * best));
  if (has_avx512) {
    const double ratio = ns(Vectors::avx2) / best;
    std::printf("With AVX2 it takes %.2f times what it takes with AVX-512, at most 1.4: %s.\n",
                ratio, verdict(ratio <= 1.4));
  }
}

// Row 10: what a cached field takes, as the server's cache counts it.
void print_fields() {
  const Prepared prepared(shapes::icosphere(5));
  const auto bytes = [&](Method method, Bound bound = Bound::none) {
    const Field field = Solver(method, bound)(prepared, 0);
    return static_cast<double>(field.bytes()) / static_cast<double>(field.distance.size());
  };
  const double with_parents = bytes(Method::wavefront);
  const double without =
      std::max(bytes(Method::back_traced), bytes(Method::back_traced, Bound::upper));
  std::printf(
      "\n### 10. Fields\n\n%.1f bytes a vertex with parents (`wavefront`), at most 16: %s; %.1f "
      "without (`auto`), at most 4: %s.\n",
      with_parents, verdict(std::floor(with_parents) <= 16), without,
      verdict(std::floor(without) <= 4));
}

}  // namespace

void print_frontier(const FrontierOptions& options) {
  const std::vector<FrontierMesh> meshes =
      options.files.empty() ? frontier_meshes(options.quick) : meshes_of(options.files);
  std::vector<MeshRow> rows;
  std::puts(
      "### 1. The default, `method=auto`\n\n"
      "y: times of the textbook edge Dijkstra.\n\n"
      "| mesh | mean error | aim | | 99.9th percentile | aim | | maximum | aim | | y | aim | | "
      "`wavefront`, y | at most 1.2 | `dijkstra`, y | at most 1.0 "
      "|\n|---|--:|--:|---|--:|--:|---|--:|--:|---|--:|--:|---|--:|---|--:|---|");
  for (const FrontierMesh& mesh : meshes) {
    const std::size_t sources = mesh.large ? 1 : options.quick ? 2 : 5;
    rows.push_back(measure(mesh, sources));
    print_default(mesh, rows.back());
  }
  std::puts(
      "\n### 2. `bound=upper`\n\n| mesh | mean error | at most 0.016 % | y | at most 6 | most "
      "below the truth | 1e-9 |\n|---|--:|---|--:|---|--:|---|");
  for (std::size_t i = 0; i < meshes.size(); ++i) print_upper(meshes[i], rows[i]);
  std::puts(
      "\n### 3. `tolerance`\n\nTimes of exact / mean error / largest error; the last column says "
      "whether no error is above what was asked, nor any distance below the true one. At most 0.33 "
      "and 0.50 times for 1e-2 and 1e-3.\n\n| mesh | 1e-2 | 1e-3 | 1e-4 | 1e-5 | 1e-6 | kept "
      "|\n|---|--:|--:|--:|--:|--:|---|");
  for (std::size_t i = 0; i < meshes.size(); ++i) print_within(meshes[i], rows[i]);
  std::puts(
      "\n### 4 and 5. `exact`, and preparing\n\n| mesh | exact, y | aim | | MB | large: "
      "below 400 | weld, connect, order and cut, y | at most 6 | bytes a vertex | at most 200 "
      "|\n|---|--:|--:|---|--:|---|--:|---|--:|---|");
  for (std::size_t i = 0; i < meshes.size(); ++i) print_exact(meshes[i], rows[i]);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    if (!meshes[i].shuffles_previous) continue;
    const double ratio = rows[i].automatic_ms / rows[i - 1].automatic_ms;
    std::printf("\nShuffled, a query takes %.2f times as long as in order, at most 1.1: %s.\n",
                ratio, verdict(ratio <= 1.1));
  }
  print_pairs(meshes, options.quick);
  std::puts(
      "\n### 7. Paths by the default's field, refined\n\n| mesh | pairs | longer than the shortest "
      "| at most 0.005 % | longer by 0.1 % | in less than 1 % | ms, median | below 0.3 "
      "|\n|---|--:|--:|---|--:|---|--:|---|");
  for (const FrontierMesh& mesh : meshes) {
    if (mesh.is_scan) print_paths(mesh, options.quick ? 5 : 20, options.quick ? 20 : 50);
  }
  print_vectors();
  print_fields();
  print_sources(meshes);
  print_queries(options.seed, options.files);
  print_threads(meshes);
}

}  // namespace geodesic::bench
