// What several sources, and sources inside faces, cost over one at a vertex: a part of
// `geodesic_bench --frontier`.
#pragma once

#include <span>

#include "tests/bench/frontier_meshes.h"

namespace geodesic::bench {

// Prints a Markdown table with three rows for each mesh that is not large.
void print_sources(std::span<const FrontierMesh> meshes);

}  // namespace geodesic::bench
