// Lines of equal distance on a surface: marching triangles over a field that is
// taken as linear on every edge. The values at the vertices are a method's own, so
// the lines are as right as they are; between the vertices a circle becomes a
// polygon, off by the square of the edges' length over its radius.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// A polyline whose every segment lies in one face.
struct Isoline {
  double level = 0;          // mesh units
  bool closed = false;       // then a last segment leads from the last point to the first
  double length = 0;         // mesh units, that segment included
  std::vector<Vec3> points;  // at least two, and no two in a row are equal
};

// Where a level is on the edge from the vertex below it to the one that is not: the same from
// whichever face it is asked.
[[nodiscard]] Vec3 crossing_of(const Mesh& mesh, const Field& field, double level,
                               std::uint32_t low, std::uint32_t high);

// The lines of all `levels`, which must ascend, each once: by level, and of one
// level by the number of the first face they cross.
//
// A vertex whose distance is the level counts as above it. So a line never forks
// at a vertex, and what would be one point (a peak just at its level) is no line.
// Lines end where the surface does, at faces with an unreached vertex, and at
// edges with three faces or more, where several of them meet.
//
// O(f log l + s) for f faces, l levels and s segments.
// Errors: cancelled; too_large (more segments than `max_segments`).
[[nodiscard]] Result<std::vector<Isoline>> isolines(const Adjacency& adjacency, const Field& field,
                                                    std::span<const double> levels,
                                                    std::uint64_t max_segments,
                                                    const Cancel& cancel);

// The same lines, handed on one after the other instead of kept. Errors: those of `isolines`.
[[nodiscard]] Result<void> each_isoline(const Adjacency& adjacency, const Field& field,
                                        std::span<const double> levels, std::uint64_t max_segments,
                                        const std::function<void(Isoline&&)>& take,
                                        const Cancel& cancel);

}  // namespace geodesic
