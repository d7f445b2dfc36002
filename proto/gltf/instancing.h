// EXT_mesh_gpu_instancing: how often and where a node draws its mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "proto/gltf_file/buffers.h"
#include "proto/gltf_file/document.h"

namespace geodesic::proto {

// One transform per instance, from the instance's space to that of the node whose
// `instancing` is given: translation after rotation after scale, as the extension
// says. Rotations in integers are made unit length again.
// `max_instances` is checked before memory is taken.
// Errors: those of `read_accessor`, mesh_invalid (accessors of different counts, or
// a number that is not finite), too_large.
[[nodiscard]] Result<std::vector<GltfTransform>> read_instancing(const GltfDocument& document,
                                                                 GltfBuffers& buffers,
                                                                 std::size_t node,
                                                                 std::uint64_t max_instances,
                                                                 std::uint64_t max_absent);

}  // namespace geodesic::proto
