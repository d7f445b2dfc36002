#include "tests/bench/frontier_sources.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include "core/solve/solve_field.h"
#include "tests/bench/errors.h"
#include "tests/bench/prepared.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {
namespace {

constexpr std::size_t kRounds = 9;
constexpr double kAtMost = 1.1;

struct Kind {
  std::size_t count;
  bool inside;
};
constexpr std::array<Kind, 6> kKinds{
    {{1, false}, {1, true}, {4, false}, {16, false}, {100, false}, {16, true}}};

std::vector<Source> random_sources(const Adjacency& adjacency, Kind kind, std::mt19937& random) {
  std::vector<Source> sources;
  for (std::size_t i = 0; i < kind.count; ++i) {
    const auto face = static_cast<std::uint32_t>(random() % adjacency.mesh().face_count());
    if (kind.inside) {
      sources.push_back({point_on_face(adjacency, face, {1, 2, 3}), 0});
    } else {
      sources.push_back({point_at_vertex(adjacency, adjacency.face(face).vertex[0]), 0});
    }
  }
  return sources;
}

// Over that from one vertex, in the middle: each of the rounds has its own sources.
std::array<double, kKinds.size()> ratios(const Adjacency& adjacency, Method method) {
  std::array<std::vector<double>, kKinds.size()> found;
  std::mt19937 random(7);
  SolveScratch scratch;
  FieldLimits limits;
  limits.keep_details = false;
  for (std::size_t round = 0; round < kRounds; ++round) {
    double of_one = 0;
    for (std::size_t i = 0; i < kKinds.size(); ++i) {
      const std::vector<Source> sources = random_sources(adjacency, kKinds[i], random);
      const double ms = processor_ms_of([&] {
        if (!solve_field(method, {}, adjacency, sources, limits, scratch, Cancel())) {
          give_up("no field");
        }
      });
      if (i == 0) of_one = ms;
      found[i].push_back(ms / of_one);
    }
  }
  std::array<double, kKinds.size()> middle{};
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    std::nth_element(found[i].begin(), found[i].begin() + kRounds / 2, found[i].end());
    middle[i] = found[i][kRounds / 2];
  }
  return middle;
}

// Of `auto` from all sources, by exact distances from the same.
struct FieldErrors {
  Errors errors;
  double lowest = 0;              // part by which the worst is below
  std::size_t elsewhere = 0;      // vertices whose source is not the nearest …
  double farthest_elsewhere = 0;  // … and is farther by this part at the most
};

FieldErrors errors_on(const Adjacency& adjacency, Kind kind, std::mt19937& random) {
  const std::vector<Source> sources = random_sources(adjacency, kind, random);
  SolveScratch scratch;
  const auto solve = [&](Method method, std::span<const Source> from) {
    auto field = solve_field(method, {}, adjacency, from, {}, scratch, Cancel());
    if (!field) give_up("no field");
    return std::move(*field);
  };
  const Field truth = solve(Method::exact, sources);
  const Field field = solve(Method::back_traced, sources);
  FieldErrors found{errors_of(field.distance.values(), truth.distance.values()), 0, 0, 0};
  for (std::size_t v = 0; v < truth.distance.size(); ++v) {
    if (!(truth.distance[v] > 0) || truth.distance[v] == kUnreached) continue;
    found.lowest = std::min(found.lowest, field.distance[v] / truth.distance[v] - 1);
  }
  // What each source says of the vertices that are told to be nearest to it, but not by `exact`.
  for (std::uint32_t s = 0; sources.size() > 1 && s < sources.size(); ++s) {
    std::vector<std::uint32_t> others;
    for (std::uint32_t v = 0; v < truth.distance.size(); ++v) {
      if (field.nearest_source[v] == s && truth.nearest_source[v] != s) others.push_back(v);
    }
    if (others.empty()) continue;
    const Field own = solve(Method::exact, {&sources[s], 1});
    for (const std::uint32_t v : others) {
      ++found.elsewhere;
      found.farthest_elsewhere =
          std::max(found.farthest_elsewhere, own.distance[v] / truth.distance[v] - 1);
    }
  }
  return found;
}

void print_errors(std::span<const FrontierMesh> meshes) {
  std::printf(
      "\nErrors of `auto`, once each.\n\n| mesh | sources | mean | 99.9th percentile | maximum | "
      "most below | of another source: vertices | farther by "
      "|\n|---|---|--:|--:|--:|--:|--:|--:|\n");
  for (const FrontierMesh& mesh : meshes) {
    if (mesh.large) continue;
    const Prepared prepared(mesh.soup);
    std::mt19937 random(7);
    for (const Kind& kind : kKinds) {
      const FieldErrors found = errors_on(prepared.adjacency(), kind, random);
      std::printf("| %s | %zu%s | %.4f %% | %.3f %% | %.2f %% | %.2f %% | %zu | %.3f %% |\n",
                  mesh.title.c_str(), kind.count, kind.inside ? " inside faces" : "",
                  100 * found.errors.mean, 100 * found.errors.p999, 100 * found.errors.max,
                  -100 * found.lowest, found.elsewhere, 100 * found.farthest_elsewhere);
      std::fflush(stdout);
    }
  }
}

}  // namespace

void print_sources(std::span<const FrontierMesh> meshes) {
  std::printf(
      "\n### 11. Several sources\n\nTimes of one source at a vertex.\n\n| mesh | method | inside a "
      "face | 4 vertices | 16 | 100 | 16 inside faces | all at most %.1f "
      "|\n|---|---|--:|--:|--:|--:|--:|---|\n",
      kAtMost);
  for (const FrontierMesh& mesh : meshes) {
    if (mesh.large) continue;
    const Prepared prepared(mesh.soup);
    for (const auto& [name, method] : {std::pair{"auto", Method::back_traced},
                                       {"wavefront", Method::wavefront},
                                       {"exact", Method::exact}}) {
      const auto over_one = ratios(prepared.adjacency(), method);
      std::printf("| %s | `%s` |", mesh.title.c_str(), name);
      for (std::size_t i = 1; i < kKinds.size(); ++i) std::printf(" %.2f |", over_one[i]);
      const bool reached = *std::max_element(over_one.begin() + 1, over_one.end()) <= kAtMost;
      std::printf(" %s |\n", reached ? "yes" : "**no**");
      std::fflush(stdout);
    }
  }
  print_errors(meshes);
}

}  // namespace geodesic::bench
