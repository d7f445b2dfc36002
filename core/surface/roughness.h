// Whether a surface bends much from face to face, as a crumpled sheet or a coarse model does and a
// scan does not. What a method takes for locally smooth is less so there.
#pragma once

#include <span>

#include "core/base/vec3.h"
#include "core/surface/face_record.h"

namespace geodesic {

// Whether at more than one inner edge in five, of a sample of 4096, the two faces' planes differ by
// more than 15 degrees. `faces` have their rings; positions are by vertex. Edges between faces
// without area, and of more than two faces, do not count. O(1).
[[nodiscard]] bool is_rough(std::span<const FaceRecord> faces, std::span<const Vec3> positions);

}  // namespace geodesic
