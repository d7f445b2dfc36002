// How long the first answer takes, stage by stage: all of `geodesic_bench --cold`.
#pragma once

#include <cstdint>
#include <span>

namespace geodesic::bench {

// Prints a Markdown table: terrains of about so many vertices, as a GLB in the order of rows and
// shuffled, from its bytes to a field by `auto`, on one thread and on all of them.
void print_cold_start(std::span<const std::uint64_t> vertices);

}  // namespace geodesic::bench
