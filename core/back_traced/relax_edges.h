// No distance is above the way along an edge from a neighbour's: for fronts that
// compute a vertex from whole triangles only, and may pass an edge by.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Lowers what is above, and what that is below in turn, up to `max`; vertices that get
// a lesser distance are of the source that it came from. Leaves off when the poll says
// to stop. One look at each edge, and nothing more where nothing is to be done.
void relax_edges(const Adjacency& adjacency, double max, Field& field, Poll& poll);

// The same where only these vertices have a distance; the others stay without.
void relax_edges_among(std::span<const std::uint32_t> vertices, const Adjacency& adjacency,
                       double max, Field& field, Poll& poll);

}  // namespace geodesic
