// A curve along points of the surface, as lines that a field starts from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/line_waves.h"
#include "core/solve/solve_scratch.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// From each point to the next, and if it is closed from the last to the first: the straight line in
// a face that both lie in, or else the shortest path. Adds its pieces to `lines` and their ends to
// `sources`, both of that item, and returns its length in mesh units.
// Errors: no_loop (no way from a point to the next; `actual` is the number of the first of the
// two), too_large (more than `most` pieces in all), cancelled, too_much_memory.
[[nodiscard]] Result<double> add_curve(const Adjacency& adjacency,
                                       std::span<const SurfacePoint> points, bool is_closed,
                                       std::uint32_t item, std::size_t most, SourceLines& lines,
                                       std::vector<Source>& sources, SolveScratch& scratch,
                                       const Cancel& cancel);

}  // namespace geodesic
