// The JSON of a glTF file to a `GltfDocument`.
#pragma once

#include <string_view>

#include "core/error.h"
#include "proto/decoded_mesh.h"
#include "proto/gltf_document.h"

namespace geodesic::proto {

// Errors: mesh_invalid, extension_required, too_large.
[[nodiscard]] Result<GltfDocument> parse_gltf(std::string_view json, const DecodeLimits& limits);

}  // namespace geodesic::proto
