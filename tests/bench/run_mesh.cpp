#include "tests/bench/run_mesh.h"

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "core/field/vertex_heap.h"
#include "proto/wire/methods.h"
#include "tests/bench/edge_dijkstra.h"
#include "tests/bench/pairing_heap.h"
#include "tests/bench/peer.h"
#include "tests/bench/prepared.h"
#include "tests/bench/queue_wave.h"

namespace geodesic::bench {
namespace {

// A repetition lasts at least so long, in seconds.
constexpr double kLeastTime = 0.05;
// A peer that takes longer for one field is not asked again.
constexpr double kSlowPeerMs = 5000;

using Times = std::map<std::string, std::vector<double>>;  // milliseconds by name

// Collects what each repetition took, and prints nothing.
class Collector : public benchmark::BenchmarkReporter {
 public:
  explicit Collector(Times& times) : times_(times) {}
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      times_[run.run_name.function_name].push_back(run.GetAdjustedRealTime());
    }
  }

 private:
  Times& times_;
};

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void time_work(const std::string& name, std::function<void()> work) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [work = std::move(work)](benchmark::State& state) {
                                 for (auto _ : state) work();
                               })
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond)
      ->MinTime(kLeastTime);
}

// Ties may come in another order, which moves a distance by rounding only.
bool agree(std::span<const double> a, std::span<const double> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
    return x == y || std::abs(x - y) <= 1e-6 * std::max(x, y);
  });
}

// The mesh as peers get it: in the file's order, without vertices in no face, which
// some of them cannot take. Removed at the end.
class MeshFolder {
 public:
  explicit MeshFolder(const TriangleSoup& soup) {
    std::string pattern = std::filesystem::temp_directory_path() / "geodesic_bench.XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) give_up("no temporary folder");
    path_ = pattern;
    std::vector<std::uint32_t> number(soup.positions.size(), kNone);
    for (const auto& face : soup.faces) {
      for (const std::uint32_t v : face) number[v] = 0;
    }
    std::vector<Vec3> positions;
    for (std::uint32_t v = 0; v < number.size(); ++v) {
      if (number[v] == kNone) continue;
      number[v] = static_cast<std::uint32_t>(positions.size());
      positions.push_back(soup.positions[v]);
      used_.push_back(v);
    }
    auto faces = soup.faces;
    for (auto& face : faces) {
      for (std::uint32_t& v : face) v = number[v];
    }
    source_ = number[0];
    write("positions.f64", std::as_bytes(std::span(positions)));
    write("faces.u32", std::as_bytes(std::span(faces)));
  }
  ~MeshFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  MeshFolder(const MeshFolder&) = delete;
  MeshFolder& operator=(const MeshFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::uint32_t source() const { return source_; }
  // One value a source vertex to one a vertex of the folder's.
  [[nodiscard]] std::vector<double> used(std::span<const double> values) const {
    std::vector<double> result;
    for (const std::uint32_t v : used_) result.push_back(values[v]);
    return result;
  }

 private:
  void write(const char* name, std::span<const std::byte> bytes) const {
    std::ofstream out(path_ / name, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) give_up("cannot write " + (path_ / name).string());
  }

  std::filesystem::path path_;
  std::vector<std::uint32_t> used_;
  std::uint32_t source_ = 0;
};

// The peers that are there, with their first answers; those that are fast enough are
// timed again with everything else.
class Peers {
 public:
  Peers(const Subject& subject, const std::filesystem::path& environments,
        std::span<const double> truth_by_source)
      : folder_(subject.soup) {
    const std::vector<double> truth = folder_.used(truth_by_source);
    for (const PeerSolver& solver : kPeerSolvers) {
      Entrant entrant;
      entrant.name = solver.name;
      entrant.ours = false;
      auto peer = Peer::start(solver, environments, folder_.path(), folder_.source());
      if (!peer) {
        entrant.failure = peer.error();
        entrants_.push_back({std::move(entrant), nullptr, 0});
        continue;
      }
      entrant.version = peer->version();
      entrant.prepare_ms = peer->prepare_ms();
      const auto first_ms = peer->solve();
      const auto distances =
          first_ms ? peer->distances() : tl::unexpected<std::string>(first_ms.error());
      if (!distances) {
        entrant.failure = distances.error();
        entrants_.push_back({std::move(entrant), nullptr, 0});
        continue;
      }
      entrant.errors = errors_of(*distances, truth);
      entrants_.push_back(
          {std::move(entrant), std::make_unique<Peer>(std::move(*peer)), *first_ms});
    }
  }

  void register_all(const std::string& mesh) {
    for (auto& [entrant, peer, first_ms] : entrants_) {
      if (!peer || first_ms > kSlowPeerMs) continue;
      benchmark::RegisterBenchmark((mesh + "/" + entrant.name).c_str(),
                                   [peer = peer.get()](benchmark::State& state) {
                                     for (auto _ : state) {
                                       const auto ms = peer->solve();
                                       if (!ms) {
                                         state.SkipWithError(ms.error().c_str());
                                         break;
                                       }
                                       state.SetIterationTime(*ms / 1000);
                                     }
                                   })
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond)
          ->MinTime(kLeastTime);
    }
  }

  [[nodiscard]] std::vector<Entrant> results(const std::string& mesh, Times& times) {
    std::vector<Entrant> results;
    for (auto& [entrant, peer, first_ms] : entrants_) {
      auto& own = times[mesh + "/" + entrant.name];
      if (peer && first_ms > kSlowPeerMs) own = {first_ms};
      entrant.ms = median(own);
      entrant.rounds = own.size();
      results.push_back(std::move(entrant));
    }
    return results;
  }

 private:
  struct Running {
    Entrant entrant;
    std::unique_ptr<Peer> peer;
    double first_ms;
  };
  MeshFolder folder_;
  std::vector<Running> entrants_;
};

// Ours, and what it is to do.
struct Contestant {
  std::string name;
  Method method;
  MethodOptions options;
};

std::vector<Contestant> contestants(bool with_exact) {
  std::vector<Contestant> all;
  for (const proto::MethodInfo& info : proto::all_methods()) {
    if (!info.exact || with_exact) all.push_back({std::string(info.name), info.method, {}});
  }
  if (!with_exact) return all;
  for (const auto& [text, tolerance] : {std::pair{"1e-2", 1e-2}, {"1e-3", 1e-3}, {"1e-4", 1e-4}}) {
    MethodOptions options;
    options.error_at_most = tolerance;
    all.push_back({std::string("auto ") + text, Method::back_traced, options});
  }
  return all;
}

}  // namespace

MeshResult run_mesh(const Subject& subject, const RunOptions& options) {
  const Prepared prepared(subject.soup);
  const std::uint32_t from = prepared.vertex(0);
  const Source source = prepared.source_at(0);
  const bool with_exact = prepared.mesh().vertex_count() <= options.most_vertices_for_exact;
  const auto name = [&](std::string_view what) { return subject.name + "/" + std::string(what); };

  benchmark::ClearRegisteredBenchmarks();
  time_work(name("build"), [&] { benchmark::DoNotOptimize(Mesh::build(subject.soup)); });
  auto mesh = Mesh::build(subject.soup);
  const auto shared = std::make_shared<const Mesh>(std::move(*mesh));
  time_work(name("prepare"), [&] { benchmark::DoNotOptimize(Adjacency::build(shared)); });
  Yardstick textbook(prepared.adjacency());
  time_work(name("textbook"), [&] { textbook.in_our_order().run(from); });
  time_work(name("textbook_in_file_order"), [&] { textbook.in_file_order().run(from); });
  QueueWave<VertexHeap> with_4ary(prepared.adjacency());
  QueueWave<PairingHeap> with_pairing(prepared.adjacency());
  time_work(name("queue_4ary"), [&] { with_4ary.run(source); });
  time_work(name("queue_pairing"), [&] { with_pairing.run(source); });

  std::vector<double> truth;
  if (with_exact) truth = prepared.solve(Method::exact).distance.values();
  SolveScratch scratch;
  std::vector<Entrant> methods;
  for (const Contestant& contestant : contestants(with_exact)) {
    const auto solve = [&prepared, &scratch, contestant] {
      FieldLimits limits;
      limits.keep_details = false;  // distances alone, as others compute them
      return prepared.solve(contestant.method, 0, scratch, contestant.options, limits);
    };
    const Field field = solve();
    Entrant entrant;
    entrant.name = contestant.name;
    if (with_exact) entrant.errors = errors_of(field.distance.values(), truth);
    methods.push_back(std::move(entrant));
    time_work(name(contestant.name), [solve] { benchmark::DoNotOptimize(solve()); });
  }
  std::optional<Peers> peers;
  if (with_exact && !options.peers.empty()) {
    peers.emplace(subject, options.peers, prepared.in_source_order(truth));
    peers->register_all(subject.name);
  }

  Times times;
  Collector collector(times);
  benchmark::RunSpecifiedBenchmarks(&collector);
  benchmark::ClearRegisteredBenchmarks();

  const Field field = prepared.solve(Method::wavefront, 0, scratch);
  with_4ary.run(source);
  with_pairing.run(source);
  if (!agree(with_4ary.distance(), field.distance.values())) give_up("the loops disagree");
  if (!agree(with_pairing.distance(), field.distance.values())) give_up("the queues disagree");

  MeshResult result;
  result.name = subject.name;
  result.title = subject.title;
  result.vertices = prepared.mesh().vertex_count();
  result.faces = prepared.mesh().face_count();
  result.build_ms = median(times[name("build")]);
  result.prepare_ms = median(times[name("prepare")]);
  result.textbook_ms =
      std::min(median(times[name("textbook")]), median(times[name("textbook_in_file_order")]));
  result.pairing_over_4ary =
      median(times[name("queue_pairing")]) / median(times[name("queue_4ary")]);
  result.field_bytes_per_vertex =
      static_cast<double>(field.bytes()) / static_cast<double>(result.vertices);
  result.adjacency_bytes_per_vertex =
      static_cast<double>(prepared.adjacency().bytes()) / static_cast<double>(result.vertices);
  for (Entrant& entrant : methods) {
    entrant.ms = median(times[name(entrant.name)]);
    entrant.rounds = times[name(entrant.name)].size();
    result.entrants.push_back(std::move(entrant));
  }
  if (peers) {
    for (Entrant& entrant : peers->results(subject.name, times)) {
      result.entrants.push_back(std::move(entrant));
    }
  }
  for (Entrant& entrant : result.entrants) entrant.over_textbook = entrant.ms / result.textbook_ms;
  return result;
}

}  // namespace geodesic::bench
