// A path along edges from one point to another, found without looking at much of the
// mesh: A* (Hart, Nilsson, Raphael, "A formal basis for the heuristic determination of
// minimum cost paths", 1968), with the straight line in space as what is left to go. That
// line weighs more than it should (Pohl, "Heuristic search viewed as path finding in a
// graph", 1970), so the path need not be the shortest one; but it is found much sooner.
#pragma once

#include <optional>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "core/wavefront/wavefront.h"

namespace geodesic {

// At most this many times as long as the shortest way along edges.
inline constexpr double kWeightOfTheRest = 1.4;

// From a point in a face it goes straight to the corners. Nothing when there is no way
// over the surface. Errors: cancelled.
[[nodiscard]] Result<std::optional<Path>> edge_path(const Adjacency& adjacency,
                                                    const SurfacePoint& from,
                                                    const SurfacePoint& to,
                                                    WavefrontScratch& scratch,
                                                    const Cancel& cancel);

// How long a way is that is found likewise along the edges of the intrinsic Delaunay triangulation:
// more evenly above the shortest over the surface where the mesh's faces are long and thin. Errors:
// cancelled.
[[nodiscard]] Result<std::optional<double>> delaunay_edge_distance(const Adjacency& adjacency,
                                                                   const SurfacePoint& from,
                                                                   const SurfacePoint& to,
                                                                   WavefrontScratch& scratch,
                                                                   const Cancel& cancel);

}  // namespace geodesic
