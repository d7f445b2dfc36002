// GLB and glTF files to triangles in source-vertex order.
#pragma once

#include <cstddef>
#include <span>

#include "core/base/error.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/wire/import_options.h"

namespace geodesic::proto {

// `format` is `glb` or `gltf`, as `sniff_format` found it. Errors: see
// `decode_mesh`. Throws what memory allocation throws.
[[nodiscard]] Result<DecodedMesh> decode_gltf(std::span<const std::byte> bytes, MeshFormat format,
                                              const DecodeLimits& limits,
                                              const ImportOptions& options);

}  // namespace geodesic::proto
