// Rows of queries that say more than a point: lines as sources, regions, costs, tables.
#pragma once

#include "tests/bench/frontier_asked.h"

namespace geodesic::bench {

// Off by: distances, at the most, from those by `exact` from the same lines.
[[nodiscard]] Figures from_a_curve(Asked& asked);

// What is between two distances from the source is forbidden, but for one side of it. Off by:
// distances, at the most, from those by `exact` on what is left.
[[nodiscard]] Figures in_a_region(Asked& asked);

// One side costs three times as much. Off by: the mean above what more than twice as many points
// on edges find, for nothing finds the least.
[[nodiscard]] Figures by_weights(Asked& asked);

// Off by: the largest difference of an entry from that by `exact`.
[[nodiscard]] Figures tables(Asked& asked);

}  // namespace geodesic::bench
