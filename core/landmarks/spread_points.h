// Which of many points are spread evenly: each the farthest from those before it. Gonzalez 1985,
// "Clustering to minimize the maximum intercluster distance".
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// Numbers of up to `count` of the points, beginning with the first one; fewer where all others are
// at the same vertices. How far points are apart is measured along edges, between the corners of
// their faces that have the greatest weights: each component of the surface comes before any has a
// second one. Of several as far the first is taken. Errors: cancelled.
[[nodiscard]] Result<std::vector<std::uint32_t>> spread_points(const Adjacency& adjacency,
                                                               std::span<const SurfacePoint> points,
                                                               std::size_t count,
                                                               const Cancel& cancel);

}  // namespace geodesic
