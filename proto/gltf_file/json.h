// From the JSON of a glTF file to the part of it that describes geometry,
// checked: types, ranges and references of every property that is kept, and
// the extensions that the file requires.
//
// tinygltf truncates integers, drops what does not parse without a word, copies
// every buffer, and resolves URIs and images. So it is shown a document without
// buffers, images, materials and extras, in which nothing is left to drop.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "proto/gltf_file/document.h"
#include "proto/mesh/decoded_mesh.h"

namespace geodesic::proto {

struct ReducedGltf {
  std::string json;  // for tinygltf: structure only
  // Taken out of it: buffers, and the extensions of views and nodes, by index.
  std::vector<GltfBuffer> buffers;
  std::map<std::size_t, GltfMeshopt> meshopt;
  std::map<std::size_t, GltfInstancing> instancing;
  std::vector<std::string> material_names;  // the first kMostMaterials
  std::size_t materials = 0;                // of the file
  bool has_rtc_center = false;
  // An accessor without a buffer view refers to this one, one past the file's
  // own: tinygltf refuses such accessors where Draco or sparse ones have them.
  std::size_t absent_view = 0;
  // What a parser must find in `json`; less means that it dropped something.
  std::size_t accessors = 0;
  std::size_t nodes = 0;
  std::size_t scenes = 0;
  std::size_t meshes = 0;
  std::size_t primitives = 0;
};

// Errors: mesh_invalid, extension_required, too_large; the message names the
// object, such as "accessor 3".
[[nodiscard]] Result<ReducedGltf> reduce_gltf(std::string_view json, const DecodeLimits& limits);

}  // namespace geodesic::proto
