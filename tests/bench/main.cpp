// geodesic_bench: what a distance field costs and how right it is, mesh by mesh: every
// method of ours, and the peers that are installed, in one run. Prints Markdown
// tables; `--json FILE` writes the same figures for programs.
//
// Google Benchmark does the timing, and takes its own flags (--benchmark_filter=…,
// --benchmark_repetitions=…). Without them: five repetitions of everything, in an
// order drawn at random, so that a machine that slows down does so for all alike.
#include <benchmark/benchmark.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/bench/cold_start.h"
#include "tests/bench/family.h"
#include "tests/bench/frontier.h"
#include "tests/bench/frontier_meshes.h"
#include "tests/bench/frontier_queries.h"
#include "tests/bench/frontier_threads.h"
#include "tests/bench/run_mesh.h"

using namespace geodesic;
using bench::Entrant;
using bench::MeshResult;
using bench::Subject;

namespace {

std::vector<Subject> subjects(bool quick) {
  std::vector<Subject> all;
  // "Nearly 20 000 vertices", the paper says of its timing.
  all.push_back({"plane_142", "plane, 142 x 142", shapes::plane(142, 142), {}, {}});
  for (Subject& subject : bench::formula_subjects(bench::Scale::full)) {
    // The plane is there already.
    if (subject.name != "plane") all.push_back(std::move(subject));
  }
  if (quick) return all;
  for (Subject& subject : bench::scanned_subjects()) all.push_back(std::move(subject));
  Subject million{"million", "terrain, a million vertices", shapes::terrain(1000, 20, 1), {}, {}};
  Subject shuffled{"shuffled", "the same, shuffled", shapes::shuffled(million.soup, 1), {}, {}};
  all.push_back(std::move(million));
  all.push_back(std::move(shuffled));
  return all;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, value < 10 ? "%.2f" : "%.1f", value);
  return text;
}

std::string percent(double share) {
  if (share == 0) return "0";
  char text[32];
  std::snprintf(text, sizeof text, share < 1e-6 ? "%.0e %%" : "%.4f %%", 100 * share);
  return text;
}

void print_entrants(const MeshResult& mesh) {
  std::printf(
      "\n### %s: %llu vertices\n\n"
      "| method | prepare ms | ms | y | mean error | maximum error | below |\n"
      "|---|--:|--:|--:|--:|--:|--:|\n",
      mesh.title.c_str(), static_cast<unsigned long long>(mesh.vertices));
  for (const Entrant& e : mesh.entrants) {
    const std::string name = e.ours ? "`" + e.name + "`" : e.name + " " + e.version;
    if (!e.failure.empty()) {
      std::printf("| %s | %s | | | | | |\n", name.c_str(), e.failure.c_str());
      continue;
    }
    const auto error = [&](auto member) {
      return e.errors ? percent((*e.errors).*member) : std::string();
    };
    std::printf("| %s | %s | %s%s | %s | %s | %s | %s |\n", name.c_str(),
                e.ours ? number(mesh.prepare_ms).c_str() : number(e.prepare_ms).c_str(),
                number(e.ms).c_str(), e.rounds == 1 ? "†" : "", number(e.over_textbook).c_str(),
                error(&bench::Errors::mean).c_str(), error(&bench::Errors::max).c_str(),
                error(&bench::Errors::share_below).c_str());
  }
  std::fflush(stdout);
}

void print_meshes(const std::vector<MeshResult>& meshes) {
  std::puts(
      "\n### All meshes\n\n"
      "| mesh | vertices | build ms | prepare ms | textbook Dijkstra ms | `dijkstra` over it | "
      "wavefront over it | pairing heap / 4-ary | field B/vertex | adjacency B/vertex |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
  for (const MeshResult& m : meshes) {
    const auto over_textbook = [&](const char* method) {
      for (const Entrant& e : m.entrants) {
        if (e.name == method) return number(e.over_textbook);
      }
      return std::string();
    };
    std::printf("| %s | %llu | %s | %s | %s | %s | %s | %s | %.1f | %.1f |\n", m.title.c_str(),
                static_cast<unsigned long long>(m.vertices), number(m.build_ms).c_str(),
                number(m.prepare_ms).c_str(), number(m.textbook_ms).c_str(),
                over_textbook("dijkstra").c_str(), over_textbook("wavefront").c_str(),
                number(m.pairing_over_4ary).c_str(), m.field_bytes_per_vertex,
                m.adjacency_bytes_per_vertex);
  }
}

nlohmann::json to_json(const MeshResult& m) {
  nlohmann::json entrants = nlohmann::json::array();
  for (const Entrant& e : m.entrants) {
    nlohmann::json entrant{{"name", e.name}, {"ours", e.ours}};
    if (!e.version.empty()) entrant["version"] = e.version;
    if (!e.failure.empty()) {
      entrant["failure"] = e.failure;
    } else {
      entrant["ms"] = e.ms;
      entrant["over_textbook"] = e.over_textbook;
      entrant["rounds"] = e.rounds;
      if (!e.ours) entrant["prepare_ms"] = e.prepare_ms;
    }
    if (e.errors) {
      entrant["mean_relative_error"] = e.errors->mean;
      entrant["rms_relative_error"] = e.errors->rms;
      entrant["p999_relative_error"] = e.errors->p999;
      entrant["max_relative_error"] = e.errors->max;
      entrant["share_below"] = e.errors->share_below;
      entrant["unreached"] = e.errors->unreached;
    }
    entrants.push_back(std::move(entrant));
  }
  return {{"mesh", m.name},
          {"title", m.title},
          {"vertices", m.vertices},
          {"faces", m.faces},
          {"build_ms", m.build_ms},
          {"prepare_ms", m.prepare_ms},
          {"textbook_dijkstra_ms", m.textbook_ms},
          {"pairing_heap_over_4ary", m.pairing_over_4ary},
          {"field_bytes_per_vertex", m.field_bytes_per_vertex},
          {"adjacency_bytes_per_vertex", m.adjacency_bytes_per_vertex},
          {"entrants", std::move(entrants)}};
}

}  // namespace

int main(int argc, char** argv) {
  // A peer that crashes is an answer, not our end.
  signal(SIGPIPE, SIG_IGN);
  std::string repetitions = "--benchmark_repetitions=5";
  std::string interleaved = "--benchmark_enable_random_interleaving=true";
  std::vector<char*> arguments{argv[0], repetitions.data(), interleaved.data()};
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  benchmark::Initialize(&count, arguments.data());

  CLI::App app("What a distance field costs, and how right it is, mesh by mesh");
  bool quick = false;
  bool frontier = false;
  std::string json_file;
  std::vector<std::string> only;
  std::vector<std::string> files;
  bench::RunOptions options;
  app.add_flag("--quick", quick,
               "only the meshes from formulas, without those of a million vertices");
  app.add_flag("--frontier", frontier,
               "what the engine aims at, cell by cell, with a verdict each; nothing else");
  std::optional<std::uint32_t> family;
  std::optional<std::uint32_t> number;
  auto* const only_family = app.add_option(
      "--family", family, "meshes drawn from this seed, with a verdict for each aim; nothing else");
  app.add_option("--number", number, "with --family: only the mesh of this number")
      ->needs(only_family);
  bool threads = false;
  app.add_flag("--threads", threads,
               "how much sooner a field is there when idle cores help; nothing else");
  bool queries = false;
  app.add_flag("--queries", queries,
               "what the queries that follow from fields cost, and how far off they are; "
               "nothing else");
  std::optional<std::uint32_t> seed;
  app.add_option("--seed", seed, "with --queries or --frontier: of the meshes of queries");
  std::vector<std::uint64_t> cold;
  app.add_option(
      "--cold", cold,
      "how long the first answer takes, stage by stage, on terrains of so many vertices; "
      "nothing else");
  app.add_option("--mesh", only, "only the meshes of these names");
  app.add_option("FILE", files,
                 "with --frontier or --threads: these meshes instead of its own; with --queries: "
                 "these, too")
      ->check(CLI::ExistingFile);
  app.add_option("--peers", options.peers, "folder of the peers' Python environments");
  app.add_option("--json", json_file, "also write the figures to this file, as JSON");
  CLI11_PARSE(app, count, arguments.data());

  if (!files.empty() && !frontier && !threads && !queries) {
    std::cerr << "FILE is for --frontier, --threads and --queries\n";
    return 2;
  }
  if (!seed) seed = static_cast<std::uint32_t>(std::random_device()());
  if (frontier) {
    bench::print_frontier({quick, files, *seed});
    return 0;
  }
  if (queries) {
    bench::print_queries(*seed, files);
    return 0;
  }
  if (threads) {
    bench::print_threads(files.empty() ? bench::frontier_meshes(quick) : bench::meshes_of(files));
    return 0;
  }
  if (!cold.empty()) {
    bench::print_cold_start(cold);
    return 0;
  }
  if (family) return bench::print_family({*family, quick, number}) ? 0 : 1;

  std::vector<MeshResult> meshes;
  for (const Subject& subject : subjects(quick)) {
    if (!only.empty() && std::find(only.begin(), only.end(), subject.name) == only.end()) continue;
    meshes.push_back(bench::run_mesh(subject, options));
    print_entrants(meshes.back());
  }
  print_meshes(meshes);
  std::puts(
      "\nDistances alone, without what paths need. Times are medians of the repetitions; y is the "
      "textbook Dijkstra's. Errors are relative and against `exact`. † timed once: slow.");

  if (json_file.empty()) return 0;
  nlohmann::json document{{"meshes", nlohmann::json::array()}};
  for (const MeshResult& mesh : meshes) document["meshes"].push_back(to_json(mesh));
  std::ofstream out(json_file);
  out << document.dump(2) << '\n';
  out.close();
  if (!out) {
    std::cerr << "cannot write " << json_file << '\n';
    return 1;
  }
  return 0;
}
