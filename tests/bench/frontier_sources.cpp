#include "tests/bench/frontier_sources.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include "core/solve/solve_field.h"
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
}

}  // namespace geodesic::bench
