#include "proto/gltf/morph.h"

#include <string>

#include "proto/gltf/accessor.h"
#include "proto/gltf/fill.h"

namespace geodesic::proto {

const std::vector<double>& weights_of_targets(const GltfNode& node, const GltfMesh& mesh) {
  return node.weights.empty() ? mesh.weights : node.weights;
}

std::vector<GltfMorphTarget> active_targets(const GltfNode& node, const GltfMesh& mesh,
                                            const GltfPrimitive& primitive) {
  const std::vector<double>& weights = weights_of_targets(node, mesh);
  std::vector<GltfMorphTarget> targets;
  for (std::size_t i = 0; i < primitive.targets.size() && i < weights.size(); ++i) {
    if (primitive.targets[i] && weights[i] != 0) {
      targets.push_back({weights[i], *primitive.targets[i]});
    }
  }
  return targets;
}

Result<void> add_targets(const GltfDocument& document, GltfBuffers& buffers,
                         std::span<const GltfMorphTarget> targets, std::uint64_t max_absent,
                         std::span<Vec3> positions) {
  std::vector<Vec3> added(positions.size());
  for (const auto& [weight, accessor] : targets) {
    const std::string name = "accessor " + std::to_string(accessor);
    if (document.accessors[accessor].count != positions.size()) {
      return fail(ErrorCode::mesh_invalid, name + " is a morph target of " +
                                               std::to_string(document.accessors[accessor].count) +
                                               " positions, but the primitive has " +
                                               std::to_string(positions.size()) + ".");
    }
    const auto elements =
        read_accessor(document, buffers, accessor, GltfUse::displacement, max_absent);
    if (!elements) return fail(elements.error());
    if (const auto bad = fill_positions(*elements, GltfTransform{}, added)) {
      return fail(ErrorCode::mesh_invalid,
                  name + ": position " + std::to_string(bad->element) + " is not finite.");
    }
    for (std::size_t i = 0; i < positions.size(); ++i) {
      positions[i] = positions[i] + weight * added[i];
    }
  }
  return {};
}

}  // namespace geodesic::proto
