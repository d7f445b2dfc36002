// The distance of any point of the surface, as right as the field's distances of vertices.
//
// Two circles round the ends of a side (virtual_source.h) tell about how far a point of a face
// is. That is no bound: where the ways to the two come from different sides, as behind a tube or
// a bump, the point seems nearer than it is, by any part of its distance. So where the distances
// of vertices are bounds, that of a point is the length of a path.
#pragma once

#include <optional>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/paths/arrive_at_point.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// kUnreached where there is none. `arrivals` are those of the field.
//
// Within a tolerance, a point of limits.detail_faces is within it, too: by windows. With
// Bound::upper, and in other faces, it is the length of the shortest of these ways: straight from
// the face's corners, and back along the field, made as short as refine_path can. That takes as
// long as such a path does, 0.2 ms on scans. Errors: cancelled.
[[nodiscard]] Result<double> distance_at_point(const Adjacency& adjacency, const Field& field,
                                               const PointArrivals& arrivals,
                                               const SurfacePoint& point, const Cancel& cancel);

// The same for whoever has refine_path's path there, if there is one: what takes long is done.
[[nodiscard]] Result<double> distance_at_point(const Adjacency& adjacency, const Field& field,
                                               const PointArrivals& arrivals,
                                               const SurfacePoint& point,
                                               const std::optional<Path>& refined,
                                               const Cancel& cancel);

}  // namespace geodesic
