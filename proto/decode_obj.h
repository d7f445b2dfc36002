// Wavefront OBJ files to triangles. Only vertices and faces are read: materials,
// normals and texture coordinates have no bearing on geometry, and no other file is
// ever opened.
//
// Libraries were looked at and left: tinyobjloader takes a word that is no number for
// zero and an index of 2^32 + 1 for 1, both without a word; Assimp gives every corner of
// a face a vertex of its own, so that none could be named by its number in the file.
#pragma once

#include <cstddef>
#include <span>

#include "core/error.h"
#include "proto/decode_mesh.h"

namespace geodesic::proto {

// Does the first line that is neither blank nor a comment begin as lines of an OBJ do?
[[nodiscard]] bool is_obj(std::span<const std::byte> bytes);

// Vertices in the order of the `v` lines, faces in that of the `f` lines. Errors:
// mesh_invalid naming the line; those of `PolygonSoup`.
[[nodiscard]] Result<DecodedMesh> decode_obj(std::span<const std::byte> bytes,
                                             const DecodeLimits& limits);

}  // namespace geodesic::proto
