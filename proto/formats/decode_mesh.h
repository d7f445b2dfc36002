// Bytes of a mesh file to triangles. The format is found from the bytes alone:
// GLB, glTF (JSON with embedded data), a Draco bitstream, OBJ, PLY or STL.
//
// The bytes are hostile: nothing outside them is ever opened, every count is
// checked against the bytes present and against `DecodeLimits` before memory is
// taken, and every fault is an `Error` that names it.
#pragma once

#include <cstddef>
#include <span>

#include "core/base/error.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/wire/import_options.h"

namespace geodesic::proto {

// Which format the bytes claim to be; `format_unknown` when none.
[[nodiscard]] Result<MeshFormat> sniff_format(std::span<const std::byte> bytes);

// Source-vertex order: the default scene depth first (scene 0 when none is
// named, all roots when there is no scene), each mesh's primitives in order, the
// vertices of each primitive's POSITION accessor. Those of points and lines count
// too, but only triangles, strips and fans make faces and parts. Faces keep the
// file's corners in order, under mirroring transforms as well. Draco's vertices
// are in decoded order, those of OBJ and PLY in the order of the file, those of STL
// three a facet.
//
// Of `options`, `scene`, `node`, `up` and `scale` are carried out; welding is for who
// builds the mesh.
//
// Errors: format_unknown, mesh_invalid, no_triangles, index_out_of_range,
// too_many_vertices, too_many_faces, external_uri, extension_required, too_large,
// value_out_of_range (a scene or node that the file does not have).
[[nodiscard]] Result<DecodedMesh> decode_mesh(std::span<const std::byte> bytes,
                                              const DecodeLimits& limits,
                                              const ImportOptions& options = {});

}  // namespace geodesic::proto
