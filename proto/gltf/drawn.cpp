#include "proto/gltf/drawn.h"

#include <algorithm>
#include <utility>

#include "proto/gltf/geometry.h"
#include "proto/gltf/scene.h"
#include "proto/mesh/findings.h"

namespace geodesic::proto {

Result<std::vector<DrawnPrimitive>> find_drawn(const GltfDocument& document, GltfBuffers& buffers,
                                               const ImportOptions& options,
                                               const DecodeLimits& limits,
                                               std::uint64_t file_bytes) {
  const auto instances = find_instances(document, buffers, options, limits, file_bytes);
  if (!instances) return fail(instances.error());
  Findings untold;
  GltfGeometries geometries(document, buffers, file_bytes, untold);
  GltfRoom room;
  room.max_vertices = std::min<std::uint64_t>(limits.max_vertices, 0xFFFFFFFF);
  room.max_faces = limits.max_faces;
  std::vector<DrawnPrimitive> drawn;
  std::uint64_t visits = 0;
  for (std::size_t k = 0; k < instances->size(); ++k) {
    const GltfInstance& instance = (*instances)[k];
    const std::size_t primitives = document.meshes[instance.mesh].primitives.size();
    for (std::size_t i = 0; i < primitives; ++i) {
      if (++visits > limits.max_nodes) {
        return fail_limit(ErrorCode::too_large, "The scene draws too many primitives.",
                          limits.max_nodes, visits);
      }
      const auto geometry = geometries.find(instance.mesh, i, room);
      if (!geometry) return fail(geometry.error());
      if (*geometry == nullptr) continue;
      const std::uint64_t vertices = (*geometry)->vertices;
      if (const auto within = room.check(vertices, (*geometry)->faces); !within) {
        return fail(within.error());
      }
      drawn.push_back({k, instance.node, instance.mesh, i, room.vertices, vertices});
      room.vertices += vertices;
      room.faces += (*geometry)->faces;
    }
  }
  return drawn;
}

}  // namespace geodesic::proto
