// The mesh of some of a mesh's faces, in the numbers of the same file.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"

namespace geodesic {

// The mesh that a file of these faces alone would be, of their vertices and with what `whole` has
// welded welded: vertices and faces have the same order, so that what is computed on it has the
// same bits. Its source vertices and faces are those of `whole`. A source vertex that is in none of
// the faces has kNone as its vertex, and a source face that is not left has kNone as its face and
// is not among those that were dropped. `is_left`: by source face; not 0 for those that stay.
// Errors: no_triangles (no face with an area's three corners is left), cancelled.
[[nodiscard]] Result<Mesh> cut_mesh(const Mesh& whole, std::span<const std::uint8_t> is_left,
                                    const Cancel& cancel);

}  // namespace geodesic
