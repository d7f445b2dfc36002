// Lowers distances to what edges allow. A front that computes a vertex from whole triangles may
// miss that a neighbour's distance plus the length of the edge is less.
#pragma once

#include <cstdint>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/field/vertex_set.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Lowers each distance to the least over its edges of the neighbour's distance plus the length,
// until none is lowered any more. Sets none above `max`. A lowered vertex gets the
// neighbour's nearest source. Stops early when the poll says so. Where nothing is lowered, looks at
// each edge once.
void relax_edges(const Adjacency& adjacency, double max, Field& field, Poll& poll);

// Which vertices get a distance that had none.
enum class Reaching : std::uint8_t { nothing_more, more };

// The same where `vertices` are all that have a distance. Those that get one are inserted.
void relax_edges_among(VertexSet& vertices, Reaching reaching, const Adjacency& adjacency,
                       double max, Field& field, Poll& poll);

}  // namespace geodesic
