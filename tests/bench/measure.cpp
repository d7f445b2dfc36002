#include "tests/bench/measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/adjacency.h"
#include "core/mesh.h"
#include "core/wavefront.h"
#include "tests/bench/edge_dijkstra.h"
#include "tests/bench/pairing_heap.h"
#include "tests/bench/queue_wave.h"

namespace geodesic::bench {
namespace {

template <class Work>
double milliseconds(Work work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

[[noreturn]] void give_up(const std::string& name, const char* why) {
  std::fprintf(stderr, "%s: %s\n", name.c_str(), why);
  std::exit(1);
}

// The mean relative error over the vertices that have a true distance.
std::optional<double> mean_error(const Subject& subject, const Mesh& mesh,
                                 std::span<const double> distance) {
  if (!subject.truth) return {};
  double sum = 0;
  std::size_t count = 0;
  for (std::uint32_t s = 0; s < mesh.source_vertex_count(); ++s) {
    const double truth = subject.truth(s);
    if (!std::isfinite(truth) || !(truth > 0)) continue;
    sum += std::abs(distance[mesh.vertex_of_source()[s]] - truth) / truth;
    ++count;
  }
  if (count == 0) return {};
  return sum / static_cast<double>(count);
}

// Ties may come in another order, which moves a distance by rounding only.
bool agree(std::span<const double> a, std::span<const double> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
    return x == y || std::abs(x - y) <= 1e-6 * std::max(x, y);
  });
}

}  // namespace

Measurement measure(const Subject& subject, int rounds) {
  Measurement result;
  result.name = subject.name;
  const auto build = [&] {
    auto mesh = Mesh::build(subject.soup);
    if (!mesh) give_up(subject.name, mesh.error().detail.c_str());
    return std::make_shared<const Mesh>(std::move(*mesh));
  };
  const auto mesh = build();
  const Adjacency adjacency = Adjacency::build(mesh);
  const std::uint32_t from = mesh->vertex_of_source()[0];
  const Source source{point_at_vertex(adjacency, from), 0};

  EdgeDijkstra dijkstra(adjacency);
  QueueWave<VertexHeap> with_4ary(adjacency);
  QueueWave<PairingHeap> with_pairing(adjacency);
  WavefrontScratch scratch;
  Field field;
  std::vector<double> build_ms, prepare_ms, dijkstra_ms, wavefront_ms, over_dijkstra, over_4ary;
  for (int round = 0; round < rounds; ++round) {
    std::shared_ptr<const Mesh> built;
    build_ms.push_back(milliseconds([&] { built = build(); }));
    std::optional<Adjacency> prepared;
    prepare_ms.push_back(milliseconds([&] { prepared = Adjacency::build(built); }));
    dijkstra_ms.push_back(milliseconds([&] { dijkstra.run(from); }));
    wavefront_ms.push_back(milliseconds([&] {
      auto computed = wavefront_field(adjacency, {&source, 1}, {}, scratch, Cancel());
      if (!computed) give_up(subject.name, computed.error().detail.c_str());
      field = std::move(*computed);
    }));
    over_dijkstra.push_back(wavefront_ms.back() / dijkstra_ms.back());
    const double ours = milliseconds([&] { with_4ary.run(source); });
    const double theirs = milliseconds([&] { with_pairing.run(source); });
    over_4ary.push_back(theirs / ours);
  }
  if (!agree(with_4ary.distance(), field.distance)) give_up(subject.name, "the loops disagree");
  if (!agree(with_pairing.distance(), field.distance)) give_up(subject.name, "the queues disagree");

  const double vertices = mesh->vertex_count();
  result.vertices = mesh->vertex_count();
  result.faces = mesh->face_count();
  result.build_ms = median(build_ms);
  result.prepare_ms = median(prepare_ms);
  result.dijkstra_ms = median(dijkstra_ms);
  result.wavefront_ms = median(wavefront_ms);
  result.over_dijkstra = median(over_dijkstra);
  result.pairing_over_4ary = median(over_4ary);
  result.mean_error = mean_error(subject, *mesh, field.distance);
  result.dijkstra_mean_error = mean_error(subject, *mesh, dijkstra.distance());
  result.field_bytes_per_vertex = static_cast<double>(field.bytes()) / vertices;
  result.adjacency_bytes_per_vertex = static_cast<double>(adjacency.bytes()) / vertices;
  return result;
}

}  // namespace geodesic::bench
