#include "tests/bench/cold_start.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/team.h"
#include "core/mesh/mesh.h"
#include "core/mesh/shapes.h"
#include "core/solve/solve_field.h"
#include "core/surface/adjacency.h"
#include "proto/encode/encode_mesh.h"
#include "proto/formats/decode_mesh.h"
#include "tests/bench/prepared.h"
#include "tests/fixtures/helping_threads.h"

namespace geodesic::bench {
namespace {

using Clock = std::chrono::steady_clock;

// The least of so many runs counts: others use the machine too.
constexpr int kRuns = 3;
constexpr std::uint64_t kManyVertices = 4'000'000;  // one run

// The most memory that the process has held since the last call, and from now on anew.
double peak_bytes() {
  std::ifstream status("/proc/self/status");
  double kilobytes = 0;
  for (std::string word; status >> word;) {
    if (word == "VmHWM:") status >> kilobytes;
  }
  std::ofstream("/proc/self/clear_refs") << 5;
  return 1024 * kilobytes;
}

struct Stages {
  double decode = 0;
  double build = 0;
  double prepare = 0;
  double field = 0;

  [[nodiscard]] double sum() const { return decode + build + prepare + field; }
};

Stages timed(std::span<const std::byte> glb, std::size_t threads) {
  Stages ms;
  auto begin = Clock::now();
  const auto lap = [&begin] {
    const auto end = Clock::now();
    return std::chrono::duration<double, std::milli>(end - std::exchange(begin, end)).count();
  };
  Team team(threads);
  const fixtures::HelpingThreads helping(team, threads - 1);
  const Cancel cancel([] { return false; }, {}, nullptr, threads > 1 ? &team : nullptr);
  auto decoded = proto::decode_mesh(glb, {}, {});
  if (!decoded) give_up("the mesh is not decoded");
  ms.decode = lap();
  auto mesh = Mesh::build(decoded->soup, Weld::by_position, cancel);
  if (!mesh) give_up("no mesh");
  decoded->soup = {};
  ms.build = lap();
  const auto adjacency = Adjacency::build(std::make_shared<const Mesh>(std::move(*mesh)), cancel);
  if (!adjacency) give_up("no adjacency");
  ms.prepare = lap();
  const Source source{point_at_vertex(*adjacency, 0), 0};
  SolveScratch scratch;
  if (!solve_field(Method::back_traced, {}, *adjacency, {&source, 1}, {}, scratch, cancel)) {
    give_up("no field");
  }
  ms.field = lap();
  return ms;
}

Stages least(std::span<const std::byte> glb, std::size_t threads, int runs) {
  Stages least = timed(glb, threads);
  for (int run = 1; run < runs; ++run) {
    const Stages ms = timed(glb, threads);
    least = {std::min(least.decode, ms.decode), std::min(least.build, ms.build),
             std::min(least.prepare, ms.prepare), std::min(least.field, ms.field)};
  }
  return least;
}

}  // namespace

void print_cold_start(std::span<const std::uint64_t> vertices) {
  const std::size_t threads = std::max(1U, std::thread::hardware_concurrency());
  std::printf(
      "\n### From the bytes of a file to the first field\n\nTerrains, ms on the clock, on one "
      "thread and on %zu; without network, digest and store.\n\n"
      "| vertices | order | threads | decode | weld and order | prepare | field by `auto` | all | "
      "ns a vertex | most memory, bytes a vertex | times as quick |\n"
      "|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
      threads);
  for (const std::uint64_t wanted : vertices) {
    const auto side =
        static_cast<std::uint32_t>(std::lround(std::sqrt(static_cast<double>(wanted))));
    for (const bool shuffled : {false, true}) {
      std::vector<std::byte> glb;
      {
        TriangleSoup soup = shapes::terrain(side, 20, 1);
        if (shuffled) soup = shapes::shuffled(soup, 1);
        glb = proto::encode_glb(soup, "terrain");
      }
      const double count = static_cast<double>(side) * side;
      const int runs = wanted < kManyVertices ? kRuns : 1;
      double alone = 0;
      for (const std::size_t number : {std::size_t{1}, threads}) {
        (void)peak_bytes();
        const Stages ms = least(glb, number, runs);
        const double peak = peak_bytes() / count;
        if (number == 1) alone = ms.sum();
        std::printf("| %.0f | %s | %zu | %.0f | %.0f | %.0f | %.0f | %.0f | %.0f | %.0f | %.2f |\n",
                    count, shuffled ? "shuffled" : "of rows", number, ms.decode, ms.build,
                    ms.prepare, ms.field, ms.sum(), 1e6 * ms.sum() / count, peak, alone / ms.sum());
        std::fflush(stdout);
        if (threads == 1) break;
      }
    }
  }
}

}  // namespace geodesic::bench
