// STL files, in text and in binary, to triangles. Of Debian's libraries only Assimp
// reads them from memory; see decode_ply.h.
#pragma once

#include <cstddef>
#include <span>

#include "core/error.h"
#include "proto/decode_mesh.h"

namespace geodesic::proto {

// A binary one is told by its length, which follows from its number of facets; many
// of them begin with "solid" too. A text begins with that, and has a facet or none.
[[nodiscard]] bool is_stl(std::span<const std::byte> bytes);

// Three vertices a facet, in the order of the file; normals and attributes are not
// looked at. Errors: mesh_invalid naming the facet or the line, no_triangles,
// too_many_vertices, too_many_faces.
[[nodiscard]] Result<DecodedMesh> decode_stl(std::span<const std::byte> bytes,
                                             const DecodeLimits& limits);

}  // namespace geodesic::proto
