// The last way down a distance field: along edges to whatever vertex is closer to the
// sources.
#pragma once

#include <cstdint>
#include <vector>

#include "core/adjacency.h"
#include "core/arrive_at_point.h"
#include "core/field.h"

namespace geodesic {

// From a vertex along edges to the nearest one, that way, with a lesser distance: none
// only from a vertex that no other of its component is below. Takes as long as the
// vertices in between are many, of which approximate fields have few.
[[nodiscard]] std::vector<StepBack> down_edges(const Adjacency& adjacency, const Field& field,
                                               std::uint32_t vertex);

}  // namespace geodesic
