// Dijkstra 1959 on the edges of the mesh: what visits every vertex in the order of
// its distance can hardly cost less, and no shortest path on the surface is longer.
#pragma once

#include <span>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "core/wavefront/wavefront.h"

namespace geodesic {

// The lengths of the shortest ways along edges from the nearest of the sources.
// From a source inside a face, and to its corners, the way is straight.
// O(n log n) for n vertices. Errors: cancelled.
[[nodiscard]] Result<Field> edge_dijkstra_field(const Adjacency& adjacency,
                                                std::span<const Source> sources,
                                                const FieldLimits& limits,
                                                WavefrontScratch& scratch, const Cancel& cancel);

}  // namespace geodesic
