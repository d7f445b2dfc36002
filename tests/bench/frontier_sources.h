// What several sources, and sources inside faces, cost over one at a vertex: a part of
// `geodesic_bench --frontier`.
#pragma once

#include <span>

#include "tests/bench/frontier_meshes.h"

namespace geodesic::bench {

// Prints two Markdown tables, of the meshes that are not large: times, and the errors of `auto`.
void print_sources(std::span<const FrontierMesh> meshes);

}  // namespace geodesic::bench
