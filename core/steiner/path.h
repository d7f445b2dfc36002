// The selective refinement of Kanai and Suzuki 2001: a path found in the
// graph of `steiner`, and found again and again in a graph of the faces around it
// with more and more points on their edges.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/method.h"
#include "core/field/travel_cost.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "core/wavefront/wavefront.h"

namespace geodesic {

// The path from a source to any point; nothing when it cannot be reached. The first
// one is the shortest in the graph with `options.points_per_edge` points on every
// edge. Each round then halves the spacing of the points, puts them on the edges
// around the last path only, and follows the path there until it settles; the last
// round is the first that shortens the path by less than `options.tolerance` of its
// length. A round keeps the points of the path before it, so no path is ever longer.
// The result is a shortest path among its neighbours: where several ways round a
// hill are nearly equal, it is the one that the first graph preferred.
// With a cost, the same of the cheapest way from the source to the point: no round makes it dearer.
// Errors: cancelled; value_out_of_range ("points_per_edge", as of steiner_field;
// "tolerance" when it is negative or no number).
[[nodiscard]] Result<std::optional<Path>> steiner_path(
    const Adjacency& adjacency, const Source& from, const SurfacePoint& to,
    const MethodOptions& options, WavefrontScratch& scratch, const Cancel& cancel,
    const std::shared_ptr<const TravelCost>& cost = nullptr);

// What each segment of a path costs, one fewer than it has points.
[[nodiscard]] std::vector<double> segment_costs(const Path& path, const TravelCost& cost);

}  // namespace geodesic
