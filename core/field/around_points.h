// The faces and the vertices around points of a surface: what decides the distances of these.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// Every face that one of the points lies in, once and in ascending order; none of a point at a
// vertex, whose distance is the vertex's. Many points on one edge cost no more than its faces,
// which may be all that the mesh has. Errors: cancelled.
[[nodiscard]] Result<std::vector<std::uint32_t>> faces_around(const Adjacency& adjacency,
                                                              std::span<const SurfacePoint> points,
                                                              const Cancel& cancel);

// The vertices of those faces, and the vertices that points are at, once and in ascending order.
// Errors: cancelled.
[[nodiscard]] Result<std::vector<std::uint32_t>> vertices_around(
    const Adjacency& adjacency, std::span<const SurfacePoint> points, const Cancel& cancel);

}  // namespace geodesic
