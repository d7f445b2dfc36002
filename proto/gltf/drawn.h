// Which source vertices each primitive of the scene has: the same walk as decoding, without its
// numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "proto/gltf_file/buffers.h"
#include "proto/gltf_file/document.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/wire/import_options.h"

namespace geodesic::proto {

// A primitive, drawn once.
struct DrawnPrimitive {
  std::size_t instance = 0;  // which of find_instances (scene.h)
  std::size_t node = 0;
  std::size_t mesh = 0;
  std::size_t primitive = 0;
  std::uint64_t first_vertex = 0;
  std::uint64_t vertices = 0;
};

// In source-vertex order, points and lines too. Errors: those of `decode_gltf` but for what is
// wrong with single positions and faces.
[[nodiscard]] Result<std::vector<DrawnPrimitive>> find_drawn(const GltfDocument& document,
                                                             GltfBuffers& buffers,
                                                             const ImportOptions& options,
                                                             const DecodeLimits& limits,
                                                             std::uint64_t file_bytes);

}  // namespace geodesic::proto
