// Wavefront OBJ files to triangles. Only vertices and faces are read: materials,
// normals and texture coordinates have no bearing on geometry, and no other file is
// ever opened.
//
// Read here and not by a library, for each that Debian has was tried and changes meshes
// without a word. tinyobjloader 2.0.0rc10, by callbacks and in doubles: a coordinate of
// six digits is not the double nearest to it in 47 of 100 cases (up to 5 units in the last
// place), a word is zero, an index of 2^32 + 1 is 1, a comment behind a face is two corners,
// of a face that goes on in the next line the rest is lost. OpenMesh 9.0: coordinates are
// floats, a vertex with a word in it is left out, so that others take its number, and the
// file named by `mtllib` is opened. Assimp 5.2 gives every corner of a face a vertex of its
// own. To check lines before them is to read them, and would not mend the numbers.
#pragma once

#include <cstddef>
#include <span>

#include "core/base/error.h"
#include "proto/mesh/decoded_mesh.h"

namespace geodesic::proto {

// Does the first line that is neither blank nor a comment begin as lines of an OBJ do?
[[nodiscard]] bool is_obj(std::span<const std::byte> bytes);

// Vertices in the order of the `v` lines, faces in that of the `f` lines. Errors:
// mesh_invalid naming the line; those of `PolygonSoup`.
[[nodiscard]] Result<DecodedMesh> decode_obj(std::span<const std::byte> bytes,
                                             const DecodeLimits& limits);

}  // namespace geodesic::proto
