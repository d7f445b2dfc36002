// A lower bound: no way over the surface is shorter than the straight line in space.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/field/field.h"
#include "core/mesh/mesh.h"
#include "core/surface/point.h"

namespace geodesic {

// Straight lines from one source. Its place is kept relative to a corner of its face: the farther
// the mesh is from the origin, the more coarsely the position itself would be rounded.
class StraightLinesFrom {
 public:
  StraightLinesFrom(const Mesh& mesh, const SurfacePoint& source);

  [[nodiscard]] double squared_to(Vec3 place) const {
    const Vec3 line = (place - corner_) - beyond_;
    return dot(line, line);
  }
  // Raises the distance of a place, if it is below; whether it was so by more than rounding.
  bool raise(Vec3 place, double& distance) const;

 private:
  Vec3 corner_;
  Vec3 beyond_{};
};

// Raises the distances of these vertices to the straight line in space from their nearest source,
// where they are less. Returns whether any was less by more than rounding (1e-9 of the line). That
// one was no path's length, and what was computed from it may be wrong too. Stops early when the
// poll says to stop.
bool raise_to_straight_lines(const Mesh& mesh, std::span<const std::uint32_t> vertices,
                             Field& field, Poll& poll);
// The same, of all vertices.
bool raise_to_straight_lines(const Mesh& mesh, Field& field, Poll& poll);

// The same, of distances from this source without its offset. Where there are several sources, each
// wave's must be raised before the nearest is chosen: what is too low would win.
bool raise_to_straight_lines(const Mesh& mesh, const SurfacePoint& source,
                             std::span<const std::uint32_t> vertices, std::span<double> distance,
                             Poll& poll);

// Raises the distances of a field that is ready, if there is one: at the targets, or at all
// vertices where there are none. A vertex that comes to lie beyond `limits.max` is unreached.
// Errors: the field's, cancelled.
[[nodiscard]] Result<Field> not_below_straight_lines(const Mesh& mesh, Result<Field> field,
                                                     const FieldLimits& limits,
                                                     const Cancel& cancel);

}  // namespace geodesic
