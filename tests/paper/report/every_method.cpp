// The table that the paper never had: every method on every mesh. And the paper's
// own paragraph on time and memory, with a mesh of its size.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/wire/methods.h"
#include "tests/bench/edge_dijkstra.h"
#include "tests/bench/errors.h"
#include "tests/bench/peak_memory.h"
#include "tests/bench/prepared.h"
#include "tests/bench/processor_time.h"
#include "tests/paper/report/report.h"
#include "tests/paper/report/report_files.h"

namespace geodesic::report {
namespace {

using bench::Errors;
using bench::Prepared;

// An odd number, so that the median is one of them.
constexpr int kRounds = 7;
// What takes longer than this is timed once.
constexpr double kSlowMs = 2000;
// What takes less is repeated for so long in each round.
constexpr double kLeastMs = 20;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Measured {
  Method method;
  Field field;
  std::size_t peak_bytes = 0;
  std::vector<double> ms;  // by round
  std::vector<double> y;   // by round, in times of the textbook edge Dijkstra
};

// Of one run, on average over as many as take some time.
template <class Run>
double milliseconds_of(Run run) {
  const double start = bench::processor_ms();
  double took = 0;
  int runs = 0;
  do {
    run();
    ++runs;
    took = bench::processor_ms() - start;
  } while (took < kLeastMs);
  return took / runs;
}

// One run for the memory, with none kept from before, then the rounds: each takes
// every method in turn, so that a machine that slows down does so for all.
std::vector<Measured> measure(const Prepared& prepared, const Setting& setting) {
  std::vector<Measured> all;
  for (const Method method : setting.methods) {
    Measured measured{method, {}, 0, {}, {}};
    measured.peak_bytes = bench::peak_bytes_of([&] { measured.field = prepared.solve(method); });
    all.push_back(std::move(measured));
  }
  SolveScratch scratch;
  bench::Yardstick yardstick(prepared.adjacency());
  const std::uint32_t source = prepared.vertex(0);
  const int rounds = setting.scale == bench::Scale::full ? kRounds : 1;
  for (int round = 0; round < rounds; ++round) {
    const double textbook_ms =
        std::min(milliseconds_of([&] { yardstick.in_our_order().run(source); }),
                 milliseconds_of([&] { yardstick.in_file_order().run(source); }));
    for (Measured& measured : all) {
      if (!measured.ms.empty() && measured.ms.front() > kSlowMs) continue;
      measured.ms.push_back(
          milliseconds_of([&] { (void)prepared.solve(measured.method, 0, scratch); }));
      measured.y.push_back(measured.ms.back() / textbook_ms);
    }
  }
  return all;
}

const std::vector<std::string> kColumns{"mesh",        "title",      "vertices",   "method",
                                        "mean_error",  "rms_error",  "p999_error", "max_error",
                                        "share_below", "unreached",  "y",          "ms",
                                        "rounds",      "peak_bytes", "field_bytes"};

void add_rows(Table& table, const bench::Subject& subject, const Prepared& prepared,
              const std::vector<Measured>& all) {
  const auto exact = std::find_if(all.begin(), all.end(),
                                  [](const Measured& m) { return m.method == Method::exact; });
  if (exact == all.end()) bench::give_up("errors need `exact`");
  for (const Measured& m : all) {
    const Errors e = bench::errors_of(m.field.distance.values(), exact->field.distance.values());
    table.row({subject.name, subject.title, prepared.mesh().vertex_count(),
               proto::name_of(m.method), e.mean, e.rms, e.p999, e.max, e.share_below,
               e.unreached + e.invented, median(m.y), median(m.ms), m.ms.size(), m.peak_bytes,
               m.field.bytes()});
  }
}

}  // namespace

void every_method(const Setting& setting, std::span<const bench::Subject> subjects) {
  Table table(setting.folder / "table.csv", kColumns);
  Table known(setting.folder / "exact.csv", {"mesh", "title", "known_from", "method", "compared",
                                             "mean_error", "max_error", "unreached"});
  for (const bench::Subject& subject : subjects) {
    const Prepared prepared(subject.soup);
    std::printf("%s: %u vertices\n", subject.title.c_str(), prepared.mesh().vertex_count());
    std::fflush(stdout);
    const auto all = measure(prepared, setting);
    add_rows(table, subject, prepared, all);
    if (subject.known.empty()) continue;
    for (const Measured& m : all) {
      if (m.method != Method::exact && m.method != Method::chen_han) continue;
      const Errors e =
          bench::errors_of(prepared.in_source_order(m.field.distance.values()), subject.known);
      known.row({subject.name, subject.title, subject.known_from, proto::name_of(m.method),
                 e.compared, e.mean, e.max, e.unreached + e.invented});
    }
  }

  // "A mesh with nearly 20 000 vertices", the paper says.
  const std::uint32_t side = setting.scale == bench::Scale::full ? 142 : 15;
  const bench::Subject paper{"plane_of_the_paper",
                             "plane, " + std::to_string(side) + " squared",
                             shapes::plane(side, side),
                             {},
                             {}};
  const Prepared prepared(paper.soup);
  Table timing(setting.folder / "timing.csv", kColumns);
  add_rows(timing, paper, prepared, measure(prepared, setting));
}

}  // namespace geodesic::report
