// Lowers distances to what edges allow. A front that computes a vertex from whole triangles may
// miss that a neighbour's distance plus the length of the edge is less.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Lowers each distance to the least over its edges of the neighbour's distance plus the length,
// until none is lowered any more. Sets none above `max`. A lowered vertex gets the
// neighbour's nearest source. Stops early when the poll says so. Where nothing is lowered, looks at
// each edge once.
void relax_edges(const Adjacency& adjacency, double max, Field& field, Poll& poll);

// The same among `vertices`, which are all that have a distance.
void relax_edges_among(std::span<const std::uint32_t> vertices, const Adjacency& adjacency,
                       double max, Field& field, Poll& poll);

}  // namespace geodesic
