// A mesh as the engine has it, in its client's numbering: one position a source
// vertex, in their order, and one triangle a source face. Source vertices that were
// welded have the same position, and triangles name the first of them; a face that
// welding has dropped is there with the corners that it has left. So whatever a
// query says of a vertex or a face fits this geometry by its number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"

namespace geodesic::proto {

// The bytes of memory that either of these takes at most while it is made.
[[nodiscard]] std::uint64_t memory_of_geometry(const Mesh& mesh);

// As a GLB of one triangle primitive. Positions are rounded to float32, which is what
// they were unless a node moved them. Errors: unsupported, when float32 or the size
// of a GLB (4 GiB) does not hold them.
[[nodiscard]] Result<std::string> geometry_glb(const Mesh& mesh, Poll& poll);

// As a frame (array_formats.h) of `positions`, float64 [vertices, 3], and `triangles`,
// uint32 [faces, 3]; its JSON has the mesh's id and both counts. Errors: what the poll stopped by,
// here and above.
[[nodiscard]] Result<std::string> geometry_frame(std::string_view id, const Mesh& mesh, Poll& poll);

}  // namespace geodesic::proto
