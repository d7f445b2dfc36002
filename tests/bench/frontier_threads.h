// How much sooner a field is there when idle cores help: a part of `geodesic_bench --frontier`, and
// all of `geodesic_bench --threads`.
#pragma once

#include <span>

#include "tests/bench/frontier_meshes.h"

namespace geodesic::bench {

// Prints a Markdown table with a row for each mesh that is large enough to be divided. Gives up
// where a field's bits depend on the number of threads.
void print_threads(std::span<const FrontierMesh> meshes);

}  // namespace geodesic::bench
