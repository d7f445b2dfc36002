// PLY files, in text and in binary of either byte order, to triangles. Libraries were
// looked at and left: rply is not in Debian 12, OpenMesh drops what does not fit its
// half-edges, and Assimp, which comes with forty other formats, names no line at fault.
#pragma once

#include <cstddef>
#include <span>

#include "core/error.h"
#include "proto/decode_mesh.h"

namespace geodesic::proto {

// Vertices and faces in the order of the file: the elements `vertex` (x, y, z of any
// type) and `face` (the list `vertex_indices` or `vertex_index`); all else is stepped
// over. Errors: mesh_invalid naming the line, or the element and its number;
// no_triangles; those of `PolygonSoup`.
[[nodiscard]] Result<DecodedMesh> decode_ply(std::span<const std::byte> bytes,
                                             const DecodeLimits& limits);

}  // namespace geodesic::proto
