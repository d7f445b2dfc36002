// The last way down a distance field: along edges to whatever vertex is closer to the
// sources.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/paths/arrive_at_point.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// From a vertex along edges to the nearest one, that way, whose distance is less than
// `below`: none when its component has no such vertex. Goes through as many vertices as are
// on the way, in the worst case once through all of them; of no use if the poll says to stop.
[[nodiscard]] std::vector<StepBack> down_edges(const Adjacency& adjacency, const Field& field,
                                               std::uint32_t vertex, double below, Poll& poll);

}  // namespace geodesic
