// The JSON of a glTF file to a `GltfDocument`.
#pragma once

#include <string_view>

#include "core/base/error.h"
#include "proto/gltf_file/document.h"
#include "proto/mesh/decoded_mesh.h"

namespace geodesic::proto {

// Errors: mesh_invalid, extension_required, too_large.
[[nodiscard]] Result<GltfDocument> parse_gltf(std::string_view json, const DecodeLimits& limits);

}  // namespace geodesic::proto
