// What a decoder hands to `Mesh::build`: vertices and faces as the client's
// file has them, before anything is welded, ordered or checked for topology.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/vec3.h"

namespace geodesic {

struct TriangleSoup {
  std::vector<Vec3> positions;                      // one per source vertex, in source-vertex order
  std::vector<std::array<std::uint32_t, 3>> faces;  // source vertices of each source face
};

}  // namespace geodesic
