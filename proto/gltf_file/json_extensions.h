// The extensions of glTF objects that the decoder applies, checked and taken out
// of the JSON as the extensions' own schemas say, or left in it where the parser
// reads them (Draco).
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>

#include "proto/gltf_file/document.h"
#include "proto/gltf_file/json_checks.h"

namespace geodesic::proto {

// EXT_meshopt_compression or KHR_meshopt_compression of buffer view `index`, if it
// has either, into `out`.
bool take_meshopt(nlohmann::json& view, std::size_t index, std::size_t buffers, GltfChecks& checks,
                  std::map<std::size_t, GltfMeshopt>& out);

// EXT_mesh_gpu_instancing of node `index`, if it has it, into `out`.
bool take_instancing(nlohmann::json& node, std::size_t index, std::size_t accessors,
                     GltfChecks& checks, std::map<std::size_t, GltfInstancing>& out);

// Leaves of a primitive's extensions KHR_draco_mesh_compression alone, and of that
// the view and the id of the positions.
bool reduce_draco(nlohmann::json& primitive, const GltfPlace& place, std::size_t views,
                  GltfChecks& checks);

}  // namespace geodesic::proto
