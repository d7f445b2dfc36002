#include "proto/gltf/annotate.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "proto/gltf/drawn.h"
#include "proto/gltf/geometry.h"
#include "proto/gltf_file/buffers.h"
#include "proto/gltf_file/container.h"
#include "proto/gltf_file/extensions.h"
#include "proto/gltf_file/parse.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/json_outline.h"

namespace geodesic::proto {
namespace {

using nlohmann::ordered_json;

constexpr std::uint64_t kVertexData = 34962;  // glTF's number for what a view is used for
// Of the JSON of meshes that are there several times.
constexpr std::uint64_t kMostCopiedBytes = std::uint64_t{64} << 20;

tl::unexpected<Error> cannot_hold(std::string detail) {
  return fail(InputCode::not_acceptable, std::move(detail), "format");
}

std::string compact_text(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

class Annotating {
 public:
  Annotating(const GltfContainer& container, const GltfDocument& known,
             const std::vector<VertexAttribute>& attributes, ordered_json document)
      : container_(container),
        known_(known),
        attributes_(attributes),
        document_(std::move(document)) {}

  Result<GltfAnnotation> run(const std::vector<DrawnPrimitive>& drawn, const DecodeLimits& limits) {
    std::vector<DrawnPrimitive> surfaces;
    for (const DrawnPrimitive& one : drawn) {
      if (draws_triangles(primitive_of(one))) surfaces.push_back(one);
    }
    if (surfaces.size() * attributes_.size() > limits.max_gltf_objects) {
      return cannot_hold("the file has too many primitives to give each of them an accessor");
    }
    if (auto once = check_drawn_once(surfaces); !once) return fail(std::move(once.error()));
    if (auto apart = take_meshes_apart(surfaces); !apart) return fail(std::move(apart.error()));
    for (const DrawnPrimitive& one : surfaces) {
      annotation_.runs.push_back({one.first_vertex, one.vertices});
      vertices_ += one.vertices;
    }
    const std::uint64_t buffer = add_bytes();
    std::uint64_t offset = first_byte_;
    for (const VertexAttribute& attribute : attributes_) {
      if (auto added = add_attribute(surfaces, attribute, buffer, offset); !added) {
        return fail(std::move(added.error()));
      }
      offset += bytes_of(attribute);
    }
    write();
    return std::move(annotation_);
  }

  // That the values take, as floats.
  [[nodiscard]] std::uint64_t value_bytes() const {
    std::uint64_t bytes = 0;
    for (const VertexAttribute& attribute : attributes_) bytes += bytes_of(attribute);
    return bytes;
  }

 private:
  [[nodiscard]] const GltfPrimitive& primitive_of(const DrawnPrimitive& one) const {
    return known_.meshes[one.mesh].primitives[one.primitive];
  }
  [[nodiscard]] std::uint64_t bytes_of(const VertexAttribute& attribute) const {
    return vertices_ * attribute.components * sizeof(float);
  }

  [[nodiscard]] Result<void> check_drawn_once(const std::vector<DrawnPrimitive>& surfaces) const {
    std::map<std::size_t, std::size_t> instance_of;
    for (const DrawnPrimitive& one : surfaces) {
      const auto [it, is_new] = instance_of.emplace(one.node, one.instance);
      if (is_new || it->second == one.instance) continue;
      return cannot_hold("node " + std::to_string(one.node) +
                         " draws its mesh several times, and the file has one place for the "
                         "values of its vertices; the other formats have them all");
    }
    return {};
  }

  // A mesh of its own for each node: the first one keeps the file's, unless nodes that are not
  // drawn have it, too.
  Result<void> take_meshes_apart(const std::vector<DrawnPrimitive>& surfaces) {
    std::vector<std::size_t> users(known_.meshes.size());
    for (const GltfNode& node : known_.nodes) {
      if (node.mesh) ++users[*node.mesh];
    }
    for (const DrawnPrimitive& one : surfaces) {
      if (mesh_of_node_.emplace(one.node, one.mesh).second) --users[one.mesh];
    }
    std::map<std::size_t, std::uint64_t> text_of_mesh;  // bytes
    std::vector<bool> is_kept(known_.meshes.size());
    std::uint64_t copied = 0;
    for (auto& [node, mesh] : mesh_of_node_) {
      if (users[mesh] == 0 && !is_kept[mesh]) {
        is_kept[mesh] = true;
        continue;
      }
      if (has_pointers()) {
        return cannot_hold(
            "nodes share a mesh, and the file animates by KHR_animation_pointer, which would not "
            "reach the copies of it that they need; the other formats have the values");
      }
      ordered_json& meshes = document_["meshes"];
      const auto [text, is_new] = text_of_mesh.emplace(mesh, 0);
      if (is_new) text->second = compact_text(meshes[mesh]).size();
      copied += text->second;
      if (copied > kMostCopiedBytes) {
        return cannot_hold(
            "too many nodes share meshes: with a mesh for each of them, the file would become too "
            "large");
      }
      ordered_json copy = meshes[mesh];
      mesh = meshes.size();
      meshes.push_back(std::move(copy));
      document_["nodes"][node]["mesh"] = mesh;
    }
    return {};
  }

  // Whether animations name what they move by its place in the document.
  [[nodiscard]] bool has_pointers() const {
    const auto used = document_.find("extensionsUsed");
    return used != document_.end() && used->is_array() &&
           std::find(used->begin(), used->end(), "KHR_animation_pointer") != used->end();
  }

  // Room for the values: at the end of the binary chunk if the first buffer is that, else in a
  // buffer of its own.
  std::uint64_t add_bytes() {
    const bool in_chunk = container_.has_binary && !known_.buffers.empty() &&
                          !known_.buffers.front().uri &&
                          known_.buffers.front().byte_length <= container_.binary.size();
    if (in_chunk) {
      first_byte_ = container_.binary.size();
      document_["buffers"][0]["byteLength"] = first_byte_ + value_bytes();
      return 0;
    }
    is_in_text_ = true;
    ordered_json& buffers = document_["buffers"];
    buffers.push_back(
        {{"byteLength", value_bytes()}, {"uri", "data:application/octet-stream;base64,"}});
    return buffers.size() - 1;
  }

  Result<void> add_attribute(const std::vector<DrawnPrimitive>& surfaces,
                             const VertexAttribute& attribute, std::uint64_t buffer,
                             std::uint64_t offset) {
    static constexpr const char* kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    const std::uint64_t stride = attribute.components * sizeof(float);
    ordered_json& views = document_["bufferViews"];
    views.push_back({{"buffer", buffer},
                     {"byteOffset", offset},
                     {"byteLength", bytes_of(attribute)},
                     {"byteStride", stride},
                     {"target", kVertexData}});
    std::uint64_t done = 0;
    for (const DrawnPrimitive& one : surfaces) {
      ordered_json& primitive =
          document_["meshes"][mesh_of_node_[one.node]]["primitives"][one.primitive];
      if (auto free = check_is_free(primitive, one, attribute.name); !free) return free;
      ordered_json& accessors = document_["accessors"];
      primitive["attributes"][attribute.name] = accessors.size();
      accessors.push_back({{"bufferView", views.size() - 1},
                           {"byteOffset", done * stride},
                           {"componentType", static_cast<int>(gltf_float32)},
                           {"count", one.vertices},
                           {"type", kTypes[attribute.components - 1]}});
      done += one.vertices;
    }
    return {};
  }

  [[nodiscard]] Result<void> check_is_free(const ordered_json& primitive, const DrawnPrimitive& one,
                                           const std::string& name) const {
    bool is_taken = primitive["attributes"].contains(name);
    if (primitive_of(one).draco) {
      const ordered_json& draco = primitive["extensions"][std::string(kDracoExtension)];
      is_taken = is_taken || draco["attributes"].contains(name);
      // An attribute beside the Draco data has as many values as the accessors say.
      if (known_.accessors[*primitive_of(one).position].count != one.vertices) {
        return cannot_hold(name_of_primitive(one.mesh, one.primitive) +
                           ": its Draco data has another number of vertices than its accessor");
      }
    }
    if (!is_taken) return {};
    return fail(ErrorCode::value_out_of_range,
                name_of_primitive(one.mesh, one.primitive) + " has an attribute " + name +
                    " already: choose another name",
                "attribute");
  }

  // As `dump` does, but that it knows where the last buffer's data is.
  void write() {
    if (!is_in_text_) {
      annotation_.json = compact_text(document_);
      return;
    }
    std::string& text = annotation_.json;
    text = "{";
    for (const auto& [name, value] : document_.items()) {
      if (text.size() > 1) text += ',';
      text += compact_text(ordered_json(name)) + ':' + compact_text(value);
      // Behind it are the closing quote of the URI, its object and the array.
      if (name == "buffers") annotation_.values_at = text.size() - std::string_view("\"}]").size();
    }
    text += '}';
  }

  const GltfContainer& container_;
  const GltfDocument& known_;
  const std::vector<VertexAttribute>& attributes_;
  ordered_json document_;
  GltfAnnotation annotation_;
  std::map<std::size_t, std::size_t> mesh_of_node_;
  std::uint64_t vertices_ = 0;
  std::uint64_t first_byte_ = 0;  // of the values in their buffer
  bool is_in_text_ = false;
};

// Whether the file, once it is written, can be uploaded as this one was.
Result<void> check_fits(const GltfAnnotation& annotation, std::uint64_t file_bytes,
                        std::uint64_t value_bytes, bool is_glb, const DecodeLimits& limits) {
  const std::uint64_t most =
      file_bytes + annotation.json.size() + 2 * value_bytes + 16;  // base64 takes a third more
  if (is_glb && most > std::numeric_limits<std::uint32_t>::max()) {
    return cannot_hold("with the values in it, the file would not fit into a GLB of 4 GB");
  }
  auto shape = check_json_shape(annotation.json, limits);
  if (shape) {
    if (const auto document = parse_gltf(annotation.json, limits); !document) {
      shape = fail(document.error());
    }
  }
  if (shape) return {};
  return cannot_hold("with the values in it, the file could not be uploaded again: " +
                     shape.error().detail);
}

}  // namespace

Result<GltfAnnotation> annotate_gltf(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                     const ImportOptions& options,
                                     const std::vector<VertexAttribute>& attributes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const bool is_glb = text.starts_with("glTF");
  const auto container = is_glb ? open_glb(bytes) : open_gltf(bytes);
  if (!container) return fail(container.error());
  if (const auto shape = check_json_shape(container->json, limits); !shape) {
    return fail(shape.error());
  }
  const auto known = parse_gltf(container->json, limits);
  if (!known) return fail(known.error());
  if (outline_of_json(container->json).most_members > kMostOrderedMembers) {
    return cannot_hold("the file's JSON has an object of more than " +
                       std::to_string(kMostOrderedMembers) + " members");
  }
  auto document = ordered_json::parse(container->json, nullptr, /*allow_exceptions=*/false);
  if (!document.is_object()) {
    return fail(ErrorCode::mesh_invalid, "The glTF's JSON does not parse, or is not an object.");
  }
  const std::uint64_t max_decompressed = 12 * (limits.max_vertices + limits.max_faces);
  GltfBuffers buffers(*known, container->binary, container->has_binary, max_decompressed);
  const auto drawn = find_drawn(*known, buffers, options, limits, bytes.size());
  if (!drawn) return fail(drawn.error());
  Annotating annotating(*container, *known, attributes, std::move(document));
  auto annotation = annotating.run(*drawn, limits);
  if (!annotation) return annotation;
  if (auto fits = check_fits(*annotation, bytes.size(), annotating.value_bytes(), is_glb, limits);
      !fits) {
    return fail(std::move(fits.error()));
  }
  return annotation;
}

}  // namespace geodesic::proto
