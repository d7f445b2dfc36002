// What queries cost that follow from fields, and how far off they are: a part of
// `geodesic_bench --frontier`.
#pragma once

#include <span>

#include "tests/bench/frontier_meshes.h"

namespace geodesic::bench {

// Prints a Markdown table with a row for each query and mesh that is not large.
void print_queries(std::span<const FrontierMesh> meshes);

}  // namespace geodesic::bench
