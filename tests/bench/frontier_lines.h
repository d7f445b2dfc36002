// Rows of queries that say more than a point: lines as sources, regions, walls, tables.
#pragma once

#include "tests/bench/frontier_asked.h"

namespace geodesic::bench {

// Off by: distances, at the most, from those by `exact` from the same lines.
[[nodiscard]] Figures from_a_curve(Asked& asked);
[[nodiscard]] Figures from_a_curve_by_wavefront(Asked& asked);

// What is between two distances from the source is forbidden, but for one side of it. Off by:
// distances, at the most, from those by `exact` on what is left.
[[nodiscard]] Figures in_a_region(Asked& asked);

// A wall along a path. Off by: distances, at the most, from those by `exact` past the wall.
[[nodiscard]] Figures behind_a_wall(Asked& asked);

// From a closed curve, below 0 inside of it. Off by: edges whose ends have other signs although
// the curve is too far away to cross them, of all. Nothing where it separates nothing.
[[nodiscard]] Figures with_signs(Asked& asked);

// Off by: the largest difference of an entry from that by `exact`.
[[nodiscard]] Figures tables(Asked& asked);

}  // namespace geodesic::bench
