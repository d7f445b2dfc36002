// Rows of queries that read a field, or follow lines straight ahead.
#pragma once

#include "tests/bench/frontier_asked.h"

namespace geodesic::bench {

// Off by: how much longer 20 refined paths are than the shortest, the worst.
[[nodiscard]] Figures refined_paths(Asked& asked);

// Off by: the length of 10 levels together, from that by `exact`.
[[nodiscard]] Figures level_lines(Asked& asked);

// Off by: the radius within which 30 samples cover the surface, from what it is by `exact`.
[[nodiscard]] Figures samples(Asked& asked);

// Off by: where one comes to that goes as far as the farthest vertex and back, of the way.
[[nodiscard]] Figures traces(Asked& asked);

// Off by: distances of 1,000 nearest points, from those by the other hierarchy, of the farthest.
[[nodiscard]] Figures nearest_points(Asked& asked);

// Off by: the mean distance by 20 fields, from that by `exact` from the same vertices.
[[nodiscard]] Figures mean_distance(Asked& asked);

}  // namespace geodesic::bench
