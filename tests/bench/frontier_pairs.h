// Row 6 of the frontier: the way between two points, searched for, against a whole field.
#pragma once

#include <vector>

#include "tests/bench/frontier_meshes.h"

namespace geodesic::bench {

// Prints a table, a row for each mesh that is not large and each method. Ends the process
// when a method fails.
void print_pairs(const std::vector<FrontierMesh>& meshes, bool quick);

}  // namespace geodesic::bench
