// What queries cost that follow from fields, and how far off they are: a part of
// `geodesic_bench --frontier`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace geodesic::bench {

// Prints a Markdown table with a row for each query and mesh: those drawn from the seed
// (drawn_meshes), and those of the files that are not large.
void print_queries(std::uint32_t seed, const std::vector<std::string>& files);

}  // namespace geodesic::bench
