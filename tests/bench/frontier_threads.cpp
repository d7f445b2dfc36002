#include "tests/bench/frontier_threads.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <random>
#include <thread>
#include <vector>

#include "core/base/team.h"
#include "core/exact/field.h"
#include "core/solve/solve_field.h"
#include "tests/bench/prepared.h"
#include "tests/fixtures/helping_threads.h"

namespace geodesic::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kRounds = 15;
constexpr std::size_t kRoundsOfLarge = 5;
constexpr std::uint32_t kManyVertices = 200'000;
// Of `exact`, which takes half a minute on larger meshes.
constexpr std::uint32_t kMostVerticesByWindows = 300'000;
constexpr double kLeast = 1.4;
constexpr double kLeastOfMany = 1.7;
constexpr double kLeastByWindows = 1.6;

struct Timed {
  double ms;  // on the clock, threads begun and ended included
  Field field;
};

Timed timed(Method method, const Adjacency& adjacency, const Source& source, std::size_t threads,
            SolveScratch& scratch) {
  const auto begin = Clock::now();
  Team team(threads);
  auto field = [&] {
    const fixtures::HelpingThreads helping(team, threads - 1);
    const Cancel cancel([] { return false; }, {}, nullptr, threads > 1 ? &team : nullptr);
    FieldLimits limits;
    limits.keep_details = false;
    return solve_field(method, {}, adjacency, {&source, 1}, limits, scratch, cancel);
  }();
  if (!field) give_up("no field");
  return {std::chrono::duration<double, std::milli>(Clock::now() - begin).count(),
          std::move(*field)};
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// What it costs to divide a step: of one that does nothing, in microseconds.
double us_of_empty_step(std::size_t threads) {
  constexpr int kSteps = 20'000;
  Team team(threads);
  const fixtures::HelpingThreads helping(team, threads - 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(5));  // until they have come
  const Cancel never;
  Poll poll(never);
  const auto begin = Clock::now();
  for (int step = 0; step < kSteps; ++step) team.run(threads, poll, [](std::size_t, Poll&) {});
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count() / kSteps;
}

void print_row(const FrontierMesh& mesh, Method method, const Adjacency& adjacency,
               std::size_t threads) {
  const std::uint32_t vertices = adjacency.mesh().vertex_count();
  std::mt19937 random(7);
  SolveScratch scratch;
  std::array<std::vector<double>, 2> ms;
  const bool is_exact = method == Method::exact;
  const bool takes_long = is_exact || mesh.large;
  for (std::size_t round = 0; round < (takes_long ? kRoundsOfLarge : kRounds); ++round) {
    const Source source{point_at_vertex(adjacency, random() % vertices), 0};
    // In turn, for a machine may be slower at one time than at another.
    const Timed alone = timed(method, adjacency, source, 1, scratch);
    const Timed together = timed(method, adjacency, source, threads, scratch);
    const auto expected = alone.field.distance.values();
    const auto found = together.field.distance.values();
    if (!std::equal(expected.begin(), expected.end(), found.begin(), found.end())) {
      give_up("a field depends on how many threads computed it");
    }
    ms[0].push_back(alone.ms);
    ms[1].push_back(together.ms);
  }
  const double times = median(ms[0]) / median(ms[1]);
  const double least = is_exact                    ? kLeastByWindows
                       : vertices >= kManyVertices ? kLeastOfMany
                                                   : kLeast;
  std::printf("| %s | %s | %u | %.1f | %.1f | %.2f | %.1f | %s |\n", mesh.title.c_str(),
              is_exact ? "`exact`" : "`auto`", vertices, median(ms[0]), median(ms[1]), times, least,
              times >= least ? "yes" : "**no**");
  std::fflush(stdout);
}

}  // namespace

void print_threads(std::span<const FrontierMesh> meshes) {
  const std::size_t threads = std::max(1U, std::thread::hardware_concurrency());
  std::printf(
      "\n### 12. One field on %zu threads\n\nOn the clock, to the same bits. On meshes of fewer "
      "than "
      "%zu vertices nobody helps `auto`, and of fewer than %zu `exact`, which is measured up to "
      "%u. "
      "A step that does nothing takes %.2f us.\n\n"
      "| mesh | method | vertices | alone, ms | together | times as quick | aim, of 2 cores | |\n"
      "|---|---|--:|--:|--:|--:|--:|---|\n",
      threads, Team::kFewestVertices, Team::kFewestVertices / kTimesAsLongByWindows,
      kMostVerticesByWindows, us_of_empty_step(threads));
  for (const FrontierMesh& mesh : meshes) {
    const Prepared prepared(mesh.soup);
    const Adjacency& adjacency = prepared.adjacency();
    const Source source{point_at_vertex(adjacency, 0), 0};
    for (const Method method : {Method::back_traced, Method::exact}) {
      if (!can_be_helped(method, {}, adjacency, {&source, 1})) continue;
      if (method == Method::exact && prepared.mesh().vertex_count() > kMostVerticesByWindows)
        continue;
      print_row(mesh, method, adjacency, threads);
    }
  }
}

}  // namespace geodesic::bench
