// A path over the surface, whichever way it was found.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/vec3.h"
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

}  // namespace geodesic
