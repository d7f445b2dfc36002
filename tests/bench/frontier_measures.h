// Rows of queries that measure a surface or parts of it, and that move points and directions.
#pragma once

#include "tests/bench/frontier_asked.h"

namespace geodesic::bench {

// Off by: the mean of any vertex, at the most, from that by `exact` from the same vertices.
[[nodiscard]] Figures means_of_vertices(Asked& asked);

// Off by: the area of a strip, at the most, from that by `exact`; of all of the surface.
[[nodiscard]] Figures strips(Asked& asked);

// Off by: how far the section comes out of its hull, of the hull's length. Nothing where the plane
// cuts no closed curve.
[[nodiscard]] Figures hulls(Asked& asked);

// Off by: how far sites still are from their cells' centroids, on average, of the root of a cell's
// mean area.
[[nodiscard]] Figures relaxed_sites(Asked& asked);

// Off by: the area inside, from that of the same curve backwards; of all of the surface. Nothing
// where the curve separates nothing.
[[nodiscard]] Figures inside_of_a_curve(Asked& asked);

// Off by: the angle, on average, between a direction carried along a path and the one that goes on
// straight, from that at the path's beginning; of a half turn.
[[nodiscard]] Figures carried_directions(Asked& asked);

}  // namespace geodesic::bench
