// The straight way from a source line to a point, over the strips of its wave.
#pragma once

#include <optional>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/line_waves.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// `arrival` is that of waves.arrive. The way goes back along the flow of each strip, and starts at
// the foot on the segment, or at the point where that is on a source. Errors: cancelled.
[[nodiscard]] Result<std::optional<Path>> path_over_strips(const Adjacency& adjacency,
                                                           const LineWaves& waves,
                                                           const LineArrival& arrival, Poll& poll);

}  // namespace geodesic
