// The engine's frontier: what each of its aims is, what is measured, and whether it is
// reached, cell by cell. `geodesic_bench --frontier`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace geodesic::bench {

struct FrontierOptions {
  // Meshes of at most 200,000 vertices, and fewer sources and pairs: a few minutes.
  bool quick = false;
  // Mesh files to measure instead of the frontier's own meshes, as scans.
  std::vector<std::string> files;
  // Of the meshes that queries are measured on, besides those files.
  std::uint32_t seed = 0;
};

// Prints Markdown tables. Ends the process when a method fails, or a file
// cannot be read.
void print_frontier(const FrontierOptions& options);

}  // namespace geodesic::bench
