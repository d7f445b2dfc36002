// The one place that includes tinygltf. It gets a document without buffers,
// images and URIs (gltf_file/json.h), is compiled without a file system, image codecs
// and its Draco code, and so has nothing to open, to decode or to copy: it turns
// structure into structs and knows the defaults of the format.
#include "proto/gltf_file/parse.h"

#include <fstream>  // tinygltf forgets it when it has no file system
#include <limits>
#include <string>
#include <utility>

#include "proto/gltf_file/extensions.h"
#include "proto/gltf_file/json.h"
#include "proto/wire/cut_to.h"
#include "proto/wire/import_options.h"

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_USE_CPP14
#include <tiny_gltf.h>

namespace geodesic::proto {
namespace {

// Whole, if a client may choose it.
std::string kept_name(const std::string& name) { return cut_to(name, kMostChosenNameBytes); }

std::optional<std::size_t> reference(int index) {
  if (index < 0) return std::nullopt;
  return static_cast<std::size_t>(index);
}

GltfBufferView convert(const tinygltf::BufferView& from) {
  GltfBufferView view;
  view.buffer = static_cast<std::size_t>(from.buffer);
  view.offset = from.byteOffset;
  view.length = from.byteLength;
  view.stride = from.byteStride;
  return view;
}

GltfAccessor convert(const tinygltf::Accessor& from, std::size_t absent_view) {
  GltfAccessor accessor;
  accessor.view = reference(from.bufferView);
  if (accessor.view == absent_view) accessor.view.reset();
  accessor.offset = from.byteOffset;
  accessor.count = from.count;
  accessor.component_type = from.componentType;
  accessor.components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(from.type));
  accessor.normalized = from.normalized;
  accessor.min = from.minValues;
  accessor.max = from.maxValues;
  if (from.sparse.isSparse) {
    const auto& sparse = from.sparse;
    accessor.sparse = GltfSparse{static_cast<std::uint64_t>(sparse.count),
                                 static_cast<std::size_t>(sparse.indices.bufferView),
                                 static_cast<std::uint64_t>(sparse.indices.byteOffset),
                                 sparse.indices.componentType,
                                 static_cast<std::size_t>(sparse.values.bufferView),
                                 static_cast<std::uint64_t>(sparse.values.byteOffset)};
  }
  return accessor;
}

GltfPrimitive convert(const tinygltf::Primitive& from) {
  GltfPrimitive primitive;
  primitive.mode = from.mode;
  primitive.indices = reference(from.indices);
  primitive.material = reference(from.material);
  for (const auto& target : from.targets) {
    const auto it = target.find("POSITION");
    primitive.targets.push_back(it == target.end() ? std::nullopt : reference(it->second));
  }
  if (const auto it = from.attributes.find("POSITION"); it != from.attributes.end()) {
    primitive.position = reference(it->second);
  }
  if (const auto it = from.extensions.find(std::string(kDracoExtension));
      it != from.extensions.end() && primitive.position) {
    const tinygltf::Value& draco = it->second;
    const int id = draco.Get("attributes").Get("POSITION").GetNumberAsInt();
    primitive.draco = GltfDraco{static_cast<std::size_t>(draco.Get("bufferView").GetNumberAsInt()),
                                static_cast<std::uint32_t>(id)};
  }
  return primitive;
}

// Of a node; nothing when its matrix is not affine.
std::optional<GltfTransform> transform_of(const tinygltf::Node& node) {
  if (const auto& m = node.matrix; m.size() == 16) {
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) return std::nullopt;
    return transform_of_matrix(std::span<const double, 16>(m.data(), 16));
  }
  const auto vec3 = [](const std::vector<double>& v, double otherwise) {
    return v.size() == 3 ? Vec3{v[0], v[1], v[2]} : Vec3{otherwise, otherwise, otherwise};
  };
  std::array<double, 4> rotation{0, 0, 0, 1};
  if (node.rotation.size() == 4) std::copy_n(node.rotation.begin(), 4, rotation.begin());
  return transform_of_trs(vec3(node.translation, 0), rotation, vec3(node.scale, 1));
}

std::vector<std::size_t> references(const std::vector<int>& from) {
  return {from.begin(), from.end()};
}

Result<GltfDocument> convert(const tinygltf::Model& model, ReducedGltf reduced) {
  GltfDocument document;
  document.buffers = std::move(reduced.buffers);
  document.has_rtc_center = reduced.has_rtc_center;
  document.material_names = std::move(reduced.material_names);
  document.materials = reduced.materials;
  for (std::size_t i = 0; i < reduced.absent_view; ++i) {
    document.views.push_back(convert(model.bufferViews[i]));
  }
  for (const auto& [view, meshopt] : reduced.meshopt) document.views[view].meshopt = meshopt;
  for (const auto& accessor : model.accessors) {
    document.accessors.push_back(convert(accessor, reduced.absent_view));
  }
  for (const auto& from : model.meshes) {
    GltfMesh mesh{kept_name(from.name), from.weights, {}};
    for (const auto& primitive : from.primitives) mesh.primitives.push_back(convert(primitive));
    document.meshes.push_back(std::move(mesh));
  }
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const tinygltf::Node& from = model.nodes[i];
    const auto transform = transform_of(from);
    if (!transform) {
      return fail(ErrorCode::mesh_invalid,
                  "node " + std::to_string(i) + ": the last row of `matrix` is not 0 0 0 1.");
    }
    GltfNode node{kept_name(from.name),
                  reference(from.mesh),
                  references(from.children),
                  *transform,
                  from.skin >= 0,
                  from.weights,
                  {}};
    document.nodes.push_back(std::move(node));
  }
  for (const auto& [node, instancing] : reduced.instancing) {
    document.nodes[node].instancing = instancing;
  }
  for (const auto& scene : model.scenes) {
    document.scenes.push_back(references(scene.nodes));
    document.scene_names.push_back(kept_name(scene.name));
  }
  document.scene = reference(model.defaultScene);
  return document;
}

}  // namespace

Result<GltfDocument> parse_gltf(std::string_view json, const DecodeLimits& limits) {
  auto reduced = reduce_gltf(json, limits);
  if (!reduced) return fail(std::move(reduced.error()));
  if (reduced->json.size() > std::numeric_limits<unsigned int>::max()) {
    return fail_limit(ErrorCode::too_large, "The glTF's JSON is too long.",
                      std::numeric_limits<unsigned int>::max(), reduced->json.size());
  }
  tinygltf::Model model;
  std::string errors;  // quotes the file: not for a reply
  std::string warnings;
  const bool loaded =
      tinygltf::TinyGLTF().LoadASCIIFromString(&model, &errors, &warnings, reduced->json.data(),
                                               static_cast<unsigned int>(reduced->json.size()), "");
  std::size_t primitives = 0;
  for (const auto& mesh : model.meshes) primitives += mesh.primitives.size();
  // It drops what it can't read; positions in arrays would no longer be right.
  const bool complete = model.bufferViews.size() == reduced->absent_view + 1 &&
                        model.accessors.size() == reduced->accessors &&
                        model.nodes.size() == reduced->nodes &&
                        model.scenes.size() == reduced->scenes &&
                        model.meshes.size() == reduced->meshes && primitives == reduced->primitives;
  if (!loaded || !complete) {
    return fail(ErrorCode::mesh_invalid, "The structure of the glTF document is not valid.");
  }
  return convert(model, std::move(*reduced));
}

}  // namespace geodesic::proto
