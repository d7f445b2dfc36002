// The path of Tang et al. 2007, section 3.3: from a target back through the
// parents of its distance to the source.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

struct PathPoint {
  SurfacePoint point;  // in the face of the segment that leaves it, towards the target
  Vec3 position;
};

// A polyline on the surface, source first; every segment lies in one face.
struct Path {
  std::vector<PathPoint> points;
  double length = 0;         // the sum of its segments, without the source's offset
  std::uint32_t source = 0;  // which of the field's sources it starts at
};

// Nothing when the target has no distance in this field. The field must reach
// all vertices that are closer than the target: a field of all vertices, or one
// that stopped at the target.
//
// It always comes to an end: it enters a face once and comes to a vertex at most three
// times, whatever the distances are. Where distances do not lead to a source, the path is one
// along edges instead. Errors: cancelled.
[[nodiscard]] Result<std::optional<Path>> trace_path(const Adjacency& adjacency, const Field& field,
                                                     const SurfacePoint& target,
                                                     const Cancel& cancel);

}  // namespace geodesic
