// The meshes that the engine's frontier is measured on, and what it aims at on each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh/triangle_soup.h"

namespace geodesic::bench {

// At most so much.
struct Aim {
  double mean;            // of the default's relative error
  double p999;            // its 99.9th percentile; infinite: no aim
  double max;             // the largest
  double over_yardstick;  // of the default's time
  double upper;           // of the time for `bound=upper`
  double exact;           // of exact's time
};

struct FrontierMesh {
  std::string title;
  TriangleSoup soup;
  Aim aim;
  bool is_scan = false;
  bool large = false;              // half a million vertices or more
  bool shuffles_previous = false;  // the mesh before it, in another order
  std::uint32_t first_source = 0;  // a source vertex
};

// With the scans, where the shared folder is there; says on stderr where not. `quick`:
// those of at most 200,000 vertices.
[[nodiscard]] std::vector<FrontierMesh> frontier_meshes(bool quick);

// Three of a seed, of 500 to 10,242 vertices, each with a source: a closed surface with bumps of
// all sizes, as scans have; a terrain with a boundary; a machine part.
[[nodiscard]] std::vector<FrontierMesh> drawn_meshes(std::uint32_t seed);

// Those of mesh files, as scans. Ends the process when one cannot be read.
[[nodiscard]] std::vector<FrontierMesh> meshes_of(const std::vector<std::string>& files);

}  // namespace geodesic::bench
