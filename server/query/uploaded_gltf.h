// The file of a mesh, and what is to change in it for its vertices to have new attributes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "proto/gltf_file/annotation.h"

namespace geodesic::server {

struct UploadedGltf {
  std::string bytes;  // as uploaded
  proto::GltfAnnotation annotation;

  // At most so many are taken to write it with `components` floats a vertex.
  [[nodiscard]] std::uint64_t bytes_to_write(std::uint64_t components) const {
    std::uint64_t vertices = 0;
    for (const proto::VertexRun& run : annotation.runs) vertices += run.count;
    // The document twice; the values as floats, and once more in base64.
    return bytes.size() + 2 * annotation.json.size() + vertices * components * 3 * sizeof(float);
  }
};

}  // namespace geodesic::server
