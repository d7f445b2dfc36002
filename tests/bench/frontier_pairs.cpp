#include "tests/bench/frontier_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <random>

#include "core/paths/trace_path.h"
#include "core/solve/pair_search.h"
#include "tests/bench/prepared.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {
namespace {

constexpr double kMostOfAField = 0.25;   // at the median
constexpr double kMostOfASlowOne = 0.6;  // at the 90th percentile

struct PairMethod {
  Method method;
  const char* name;
  std::size_t pairs;  // that are measured
  double off;         // that counts as the same answer, relative
};

constexpr PairMethod kPairMethods[] = {
    {Method::back_traced, "auto", 60, 0},
    {Method::wavefront, "wavefront", 60, 0},
    {Method::dijkstra, "dijkstra", 60, 0},
    {Method::exact, "exact", 10, 1e-9},
};

void print_row(const FrontierMesh& mesh, const Prepared& prepared, const PairMethod& by,
               std::size_t pairs) {
  const Adjacency& adjacency = prepared.adjacency();
  SolveScratch scratch;
  std::mt19937 random(13);
  const auto any_vertex = [&] {
    std::uint32_t v = 0;
    do {
      v = static_cast<std::uint32_t>(random() % adjacency.mesh().vertex_count());
    } while (adjacency.corners(v).empty());
    return point_at_vertex(adjacency, v);
  };
  std::vector<double> ratios;
  std::size_t same = 0;
  double worst = 0;
  for (std::size_t i = 0; i < pairs; ++i) {
    const Source from{any_vertex(), 0};
    const SurfacePoint to = any_vertex();
    // What /path computes with a field, and without; both find the path.
    std::optional<Field> field;
    const double whole = processor_ms_of([&] {
      auto solved = solve_field(by.method, {}, adjacency, {&from, 1}, {}, scratch, Cancel());
      if (!solved) give_up(solved.error().detail);
      field = std::move(*solved);
      (void)trace_path(adjacency, *field, to, Cancel());
    });
    std::optional<Pair> pair;
    const double searched = processor_ms_of([&] {
      auto found =
          pair_search(by.method, {}, adjacency, from, to, PairPath::traced, scratch, Cancel());
      if (!found) give_up(found.error().detail);
      pair = std::move(*found);
    });
    ratios.push_back(searched / whole);
    const double expected = field->distance[to.vertex];
    if (pair->distance == expected) {
      ++same;
    } else {
      worst = std::max(worst, std::abs(pair->distance / expected - 1));
    }
  }
  std::sort(ratios.begin(), ratios.end());
  const double median = ratios[ratios.size() / 2];
  const double slow = ratios[ratios.size() * 9 / 10];
  std::printf("| %s | %s | %.0f %% | %s | %.0f %% | %s | %zu of %zu | %.0e | %s |\n",
              mesh.title.c_str(), by.name, 100 * median, median <= kMostOfAField ? "yes" : "**no**",
              100 * slow, slow <= kMostOfASlowOne ? "yes" : "**no**", same, pairs, worst,
              worst <= by.off ? "yes" : "**no**");
  std::fflush(stdout);
}

}  // namespace

void print_pairs(const std::vector<FrontierMesh>& meshes, bool quick) {
  std::puts(
      "\n### 6. One pair, of a whole field's time\n\n| mesh | method | median | at most 25 % | "
      "90th "
      "percentile | at most 60 % | with the same bits | else off by | the same answer "
      "|\n|---|---|--:|---|--:|---|--:|--:|---|");
  for (const FrontierMesh& mesh : meshes) {
    if (mesh.large) continue;
    const Prepared prepared(mesh.soup);
    for (const PairMethod& by : kPairMethods) {
      print_row(mesh, prepared, by, quick ? by.pairs / 3 : by.pairs);
    }
  }
}

}  // namespace geodesic::bench
