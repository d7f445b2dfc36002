// A glTF file whose vertices get attributes of our own, with everything else of it as it was.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/error.h"
#include "proto/gltf_file/annotation.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/wire/import_options.h"

namespace geodesic::proto {

// What is to change in the bytes of a GLB or glTF file, each primitive of triangles that the
// options choose getting its vertices' values as accessors of floats. A mesh has one value a
// vertex, wherever it stands: nodes that share a mesh get copies of it, which share all its
// accessors but the new ones, and a node that the options leave out keeps the mesh as it was.
// Vertices count as decoding counts them (scene.h).
// Errors: those of `decode_gltf`; not_acceptable (parameter `format`) for a node that draws its
// mesh several times, and for what would be too much for one file, or for one that is to be
// uploaded again; value_out_of_range (`attribute`) where a primitive has an attribute of the name.
[[nodiscard]] Result<GltfAnnotation> annotate_gltf(std::span<const std::byte> bytes,
                                                   const DecodeLimits& limits,
                                                   const ImportOptions& options,
                                                   const std::vector<VertexAttribute>& attributes);

}  // namespace geodesic::proto
