// PLY files, in text and in binary of either byte order, to triangles: by rply, which is
// handed every value in the order of the file, behind a header that it reads safely
// (ply_header.h). In a text, numbers are those of the C locale, which nobody here changes;
// an infinite one is refused, wherever it stands.
#pragma once

#include <cstddef>
#include <span>

#include "core/base/error.h"
#include "proto/mesh/decoded_mesh.h"

namespace geodesic::proto {

// Vertices and faces in the order of the file: the elements `vertex` (x, y, z of any
// type) and `face` (the list `vertex_indices` or `vertex_index`); all else is stepped
// over. Errors: mesh_invalid naming the line, the word, or the element and its number;
// no_triangles; those of `PolygonSoup`.
[[nodiscard]] Result<DecodedMesh> decode_ply(std::span<const std::byte> bytes,
                                             const DecodeLimits& limits);

}  // namespace geodesic::proto
