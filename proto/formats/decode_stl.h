// STL files, in text and in binary, to triangles.
//
// Read here and not by a library. Binary ones are records of 50 bytes. Of texts, Assimp
// 5.2 (10 MB, forty formats) was measured: it starts in 2 ms, crashes on nothing, and keeps
// the order, but makes floats of coordinates, a triangle of a facet of four vertices and
// meshes of NaN, refuses capital letters, takes three times the file's memory, and of 3,065
// texts damaged at random that it reads, 2,480 break the format. OpenMesh merges vertices.
#pragma once

#include <cstddef>
#include <span>

#include "core/base/error.h"
#include "proto/mesh/decoded_mesh.h"

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
