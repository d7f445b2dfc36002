// The walk that defines source-vertex order: the nodes of a scene depth first,
// children in the order of the file, transforms multiplied on the way.
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

// A mesh, drawn once.
struct GltfInstance {
  std::size_t node = 0;
  std::size_t mesh = 0;
  GltfTransform to_world;
};

// Of the scene that the options name, else the default scene, else scene 0, else
// all nodes that are nobody's child; of these only what the node that the options
// name and its descendants draw. A name is that of the first that has it.
// A node with several parents is drawn for each of them, and one that draws its
// mesh in instances (EXT_mesh_gpu_instancing) for each of these, in their order.
// Errors: mesh_invalid (a cycle, naming a node), too_large (more than `max_nodes`
// visits, instances counted), too_many_vertices (as far as nodes and accessors tell),
// value_out_of_range (`scene` or `node` is not there), those of `read_instancing`.
[[nodiscard]] Result<std::vector<GltfInstance>> find_instances(const GltfDocument& document,
                                                               GltfBuffers& buffers,
                                                               const ImportOptions& options,
                                                               const DecodeLimits& limits,
                                                               std::uint64_t max_absent);

}  // namespace geodesic::proto
