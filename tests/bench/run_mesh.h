// Everything that is measured of one mesh, side by side in one run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/bench/errors.h"
#include "tests/bench/subjects.h"

namespace geodesic::bench {

// A method of ours or a peer.
struct Entrant {
  std::string name;
  bool ours = true;
  std::string version;           // of a peer's package
  std::string failure;           // of a peer that gave no distances: why; the rest is empty then
  double prepare_ms = 0;         // of a peer, once a mesh; ours is MeshResult::prepare_ms
  double ms = 0;                 // the median
  double over_textbook = 0;      // its time in those of edge_dijkstra.h
  std::size_t rounds = 0;        // repetitions that the median is of
  std::optional<Errors> errors;  // against `exact`
};

// Times are medians in milliseconds.
struct MeshResult {
  std::string name;
  std::string title;
  std::uint64_t vertices = 0;  // after welding
  std::uint64_t faces = 0;
  double build_ms = 0;           // Mesh::build
  double prepare_ms = 0;         // Adjacency::build
  double textbook_ms = 0;        // edge_dijkstra.h
  double pairing_over_4ary = 0;  // the same wavefront on the paper's queue and on ours
  double field_bytes_per_vertex = 0;
  double adjacency_bytes_per_vertex = 0;
  std::vector<Entrant> entrants;
};

struct RunOptions {
  // Of the peers' Python environments; empty: no peers.
  std::filesystem::path peers;
  // Without `exact` there are no errors; beyond so many vertices the exact methods
  // and the peers are left out.
  std::uint64_t most_vertices_for_exact = 200'000;
};

// Runs Google Benchmark over all of it; its flags say how often and in which order.
// Ends the process when the two queues disagree or a method fails.
[[nodiscard]] MeshResult run_mesh(const Subject& subject, const RunOptions& options);

}  // namespace geodesic::bench
