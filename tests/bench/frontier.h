// The engine's frontier: what each of its aims is, what is measured, and whether it is
// reached, cell by cell. `geodesic_bench --frontier`.
#pragma once

namespace geodesic::bench {

struct FrontierOptions {
  // Meshes of at most 200,000 vertices, and fewer sources and pairs: a few minutes.
  bool quick = false;
};

// Prints Markdown tables. Ends the process when a method fails.
void print_frontier(const FrontierOptions& options);

}  // namespace geodesic::bench
