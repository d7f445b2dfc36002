// Morph targets (glTF 2.0, section 3.7.2.2) at their default weights: a position is
// that of the primitive plus, for each target, its weight times what it adds.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/error.h"
#include "core/base/vec3.h"
#include "proto/gltf_file/buffers.h"
#include "proto/gltf_file/document.h"

namespace geodesic::proto {

struct GltfMorphTarget {
  double weight = 0;
  std::size_t accessor = 0;
};

// Of the targets of its primitives: the node's, else its mesh's. What is missing is 0.
[[nodiscard]] const std::vector<double>& weights_of_targets(const GltfNode& node,
                                                            const GltfMesh& mesh);

// The targets that move something: those that have positions and a weight. All
// targets that have a weight, be it 0, are looked at.
[[nodiscard]] std::vector<GltfMorphTarget> active_targets(const GltfNode& node,
                                                          const GltfMesh& mesh,
                                                          const GltfPrimitive& primitive);

// Adds them to the positions, which are in the primitive's own space.
// Errors: those of `read_accessor`, and mesh_invalid when a target has another
// count.
[[nodiscard]] Result<void> add_targets(const GltfDocument& document, GltfBuffers& buffers,
                                       std::span<const GltfMorphTarget> targets,
                                       std::uint64_t max_absent, std::span<Vec3> positions);

}  // namespace geodesic::proto
