// The last resort of a path back to the source: along edges, to any vertex that is nearer to the
// sources.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/paths/arrive_at_point.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Returns the steps from `vertex` along edges to the vertex that is nearest along edges among those
// whose distance is less than `below`. Empty if the component has no such vertex. Visits each
// vertex at most once. If the poll says to stop, the result has no meaning.
[[nodiscard]] std::vector<StepBack> down_edges(const Adjacency& adjacency, const Field& field,
                                               std::uint32_t vertex, double below, Poll& poll);

}  // namespace geodesic
