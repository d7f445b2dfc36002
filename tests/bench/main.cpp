// geodesic_bench: what a distance field costs, mesh by mesh, in milliseconds and
// in multiples of Dijkstra's algorithm on the edges of the same mesh. Prints a
// Markdown table; `--json FILE` writes the same figures for programs.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/shapes.h"
#include "tests/bench/measure.h"
#include "tests/paper/real_meshes.h"

using namespace geodesic;
using bench::Measurement;
using bench::Subject;

namespace {

// An odd number, so that the median is one of them.
constexpr int kRounds = 7;
// "Nearly 20 000 vertices", the paper says of its timing.
constexpr std::uint32_t kPaperSide = 142;
constexpr const char* kPaperSubject = "plane 142 x 142";

Subject plane() {
  TriangleSoup soup = shapes::plane(kPaperSide, kPaperSide);
  auto truth = [positions = soup.positions](std::uint32_t v) {
    return distance(positions[v], positions[0]);
  };
  return {kPaperSubject, std::move(soup), truth};
}

Subject sphere() {
  TriangleSoup soup = shapes::icosphere(7);
  // The angle between unit vectors, in the form that is accurate for small ones.
  auto truth = [positions = soup.positions](std::uint32_t v) {
    return std::atan2(norm(cross(positions[0], positions[v])), dot(positions[0], positions[v]));
  };
  return {"icosphere(7)", std::move(soup), truth};
}

std::vector<Subject> real_meshes() {
  std::vector<Subject> subjects;
  for (const std::string name : fixtures::kRealMeshes) {
    auto loaded = fixtures::load_real_mesh(name);
    if (!loaded) {
      std::cerr << "skipped: no " << name << " with its reference; set GEODESIC_SHARED\n";
      continue;
    }
    if (!*loaded) {
      std::cerr << name << ": " << loaded->error().detail << '\n';
      std::exit(1);
    }
    fixtures::RealMesh& mesh = **loaded;
    auto truth = [exact = std::move(mesh.exact)](std::uint32_t v) {
      return fixtures::has_reference(exact[v]) ? exact[v] : INFINITY;
    };
    subjects.push_back({name, std::move(mesh.soup), std::move(truth)});
  }
  return subjects;
}

std::string percent(const std::optional<double>& share) {
  if (!share) return "";
  char text[32];
  std::snprintf(text, sizeof text, *share != 0 && *share < 1e-6 ? "%.0e %%" : "%.3f %%",
                100 * *share);
  return text;
}

void print_head() {
  std::puts(
      "| mesh | vertices | build ms | prepare ms | Dijkstra ms | wavefront ms | "
      "wavefront / Dijkstra | pairing heap / 4-ary | mean error | Dijkstra's mean error | "
      "field B/vertex | adjacency B/vertex |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
}

void print_row(const Measurement& m) {
  std::printf("| %s | %llu | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %s | %s | %.1f | %.1f |\n",
              m.name.c_str(), static_cast<unsigned long long>(m.vertices), m.build_ms, m.prepare_ms,
              m.dijkstra_ms, m.wavefront_ms, m.over_dijkstra, m.pairing_over_4ary,
              percent(m.mean_error).c_str(), percent(m.dijkstra_mean_error).c_str(),
              m.field_bytes_per_vertex, m.adjacency_bytes_per_vertex);
  std::fflush(stdout);
}

void print_comparison_with_paper(const Measurement& m) {
  std::printf(
      "\n%llu vertices in %.2f ms (paper: under 5 s on a 2.4 GHz CPU), %.0f bytes per vertex for "
      "the field (paper: one float and two ints = 12)\n",
      static_cast<unsigned long long>(m.vertices), m.wavefront_ms, m.field_bytes_per_vertex);
}

nlohmann::json to_json(const Measurement& m) {
  nlohmann::json json{{"mesh", m.name},
                      {"vertices", m.vertices},
                      {"faces", m.faces},
                      {"build_ms", m.build_ms},
                      {"prepare_ms", m.prepare_ms},
                      {"dijkstra_ms", m.dijkstra_ms},
                      {"wavefront_ms", m.wavefront_ms},
                      {"wavefront_over_dijkstra", m.over_dijkstra},
                      {"pairing_heap_over_4ary", m.pairing_over_4ary},
                      {"field_bytes_per_vertex", m.field_bytes_per_vertex},
                      {"adjacency_bytes_per_vertex", m.adjacency_bytes_per_vertex}};
  if (m.mean_error) json["mean_relative_error"] = *m.mean_error;
  if (m.dijkstra_mean_error) json["dijkstra_mean_relative_error"] = *m.dijkstra_mean_error;
  return json;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What a distance field costs, mesh by mesh");
  bool quick = false;
  std::string json_file;
  app.add_flag("--quick", quick, "leave out the meshes of a million vertices");
  app.add_option("--json", json_file, "also write the figures to this file, as JSON");
  CLI11_PARSE(app, argc, argv);

  std::vector<Measurement> measurements;
  const auto run = [&](const Subject& subject) {
    measurements.push_back(bench::measure(subject, kRounds));
    print_row(measurements.back());
  };
  print_head();
  run(plane());
  run(sphere());
  for (const Subject& subject : real_meshes()) run(subject);
  if (!quick) {
    const Subject terrain{"terrain, a million vertices", shapes::terrain(1000, 20, 1), {}};
    run(terrain);
    run({"the same, shuffled", shapes::shuffled(terrain.soup, 1), {}});
  }
  print_comparison_with_paper(measurements.front());

  if (json_file.empty()) return 0;
  nlohmann::json document{{"rounds", kRounds}, {"meshes", nlohmann::json::array()}};
  for (const Measurement& m : measurements) document["meshes"].push_back(to_json(m));
  std::ofstream out(json_file);
  out << document.dump(2) << '\n';
  out.close();
  if (!out) {
    std::cerr << "cannot write " << json_file << '\n';
    return 1;
  }
  return 0;
}
