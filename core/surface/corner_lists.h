// The corners at each vertex of triangles, as one list after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/surface/face_record.h"

namespace geodesic {

// All 3 * faces.size() corners by their vertices, in ascending order at each; those of
// vertex v are at begin[v] to begin[v + 1] of `corners`, `begin` having vertex_count + 1
// entries. Leaves off when the poll says to stop.
void list_corners(std::span<const FaceRecord> faces, std::size_t vertex_count,
                  std::vector<std::uint32_t>& begin, std::vector<std::uint32_t>& corners,
                  Poll& poll);

}  // namespace geodesic
