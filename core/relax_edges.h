// No distance is above the way along an edge from a neighbour's: for fronts that
// compute a vertex from whole triangles only, and may pass an edge by.
#pragma once

#include "core/adjacency.h"
#include "core/cancel.h"
#include "core/field.h"

namespace geodesic {

// Lowers what is above, and what that is below in turn, up to `max`; vertices that get
// a lesser distance are of the source that it came from. Leaves off when the poll says
// to stop. One look at each edge, and nothing more where nothing is to be done. Without
// `reaches_more`, vertices without a distance stay so.
void relax_edges(const Adjacency& adjacency, double max, bool reaches_more, Field& field,
                 Poll& poll);

}  // namespace geodesic
