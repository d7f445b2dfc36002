// The last step to a file that was uploaded, with attributes added: bytes to bytes, and no JSON.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "proto/gltf_file/annotation.h"

namespace geodesic::server {

// `floats`: of each attribute all values of all source vertices, float32, little-endian.
// In a GLB, what is in the binary chunk stays where it is, and so does all behind that chunk.
// Errors: cancelled; internal (the annotation is of another file, or of another surface).
[[nodiscard]] Result<std::string> write_annotated(
    std::string_view file, const proto::GltfAnnotation& annotation,
    const std::vector<proto::VertexAttribute>& attributes, const std::vector<std::string>& floats,
    Poll& poll);

}  // namespace geodesic::server
