// What is measured of one mesh.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/triangle_soup.h"

namespace geodesic::bench {

struct Subject {
  std::string name;
  TriangleSoup soup;
  // The true distance of a source vertex from source vertex 0, or not finite
  // where there is none. Empty when nothing is known about this mesh.
  std::function<double(std::uint32_t)> truth;
};

// Times are medians over the rounds, in milliseconds; ratios are medians of the
// ratios within each round, so that a machine that slows down for a while does
// not tilt them.
struct Measurement {
  std::string name;
  std::uint64_t vertices = 0;  // after welding
  std::uint64_t faces = 0;
  double build_ms = 0;                        // Mesh::build
  double prepare_ms = 0;                      // Adjacency::build
  double dijkstra_ms = 0;                     // the yardstick, edge_dijkstra.h
  double wavefront_ms = 0;                    // wavefront_field
  double over_dijkstra = 0;                   // wavefront / yardstick
  double pairing_over_4ary = 0;               // the same wavefront on the paper's queue and on ours
  std::optional<double> mean_error;           // relative
  std::optional<double> dijkstra_mean_error;  // relative, of the yardstick
  double field_bytes_per_vertex = 0;
  double adjacency_bytes_per_vertex = 0;
};

// `rounds` rounds, each of which runs everything once. Ends the process with a
// message when the mesh cannot be built or the two queues disagree: figures of
// wrong results are worth nothing.
[[nodiscard]] Measurement measure(const Subject& subject, int rounds);

}  // namespace geodesic::bench
