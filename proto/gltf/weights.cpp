#include "proto/gltf/weights.h"

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "proto/gltf/accessor.h"
#include "proto/gltf/decode.h"
#include "proto/gltf/drawn.h"
#include "proto/gltf/geometry.h"
#include "proto/gltf_file/buffers.h"
#include "proto/gltf_file/container.h"
#include "proto/gltf_file/parse.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/number.h"
#include "proto/wire/query_limits.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

constexpr const char* kWeightParameter = "weight_attribute";
// Of names in a message.
constexpr std::size_t kMostNamesTold = 20;

tl::unexpected<Error> no_weights(std::string detail) {
  return fail(ErrorCode::value_out_of_range, std::move(detail), kWeightParameter);
}

std::string primitive_name(const DrawnPrimitive& one) {
  return "mesh " + std::to_string(one.mesh) + ", primitive " + std::to_string(one.primitive);
}

std::string names_of(const json& attributes) {
  std::string names;
  std::size_t told = 0;
  for (const auto& [name, accessor] : attributes.items()) {
    if (name.size() > kMostNameBytes) continue;
    if (told == kMostNamesTold) return names + " and others";
    if (told++ > 0) names += ", ";
    names += name;
  }
  return names;
}

// The attributes of primitives, by name, as the document has them.
class Attributes {
 public:
  Attributes(const GltfDocument& known, json document, const std::string& name)
      : known_(known), document_(std::move(document)), name_(name) {}

  // The accessor of the one that was asked for.
  [[nodiscard]] Result<std::size_t> accessor_of(const DrawnPrimitive& one) const {
    const json& primitive = document_["meshes"][one.mesh]["primitives"][one.primitive];
    if (is_in_draco(primitive)) {
      return fail(InputCode::not_acceptable,
                  primitive_name(one) + " has " + name_ +
                      " compressed by Draco, which weights are not read from; send face_weights",
                  kWeightParameter);
    }
    static const json none = json::object();
    const auto given = primitive.find("attributes");
    const json& attributes = given != primitive.end() && given->is_object() ? *given : none;
    const auto found = attributes.find(name_);
    if (found == attributes.end()) {
      return no_weights(primitive_name(one) + " has no attribute " + name_ +
                        "; it has: " + names_of(attributes));
    }
    if (!found->is_number_unsigned() || found->get<std::uint64_t>() >= known_.accessors.size()) {
      return no_weights(primitive_name(one) + ": its attribute " + name_ +
                        " names an accessor that there is not");
    }
    return found->get<std::size_t>();
  }

 private:
  [[nodiscard]] bool is_in_draco(const json& primitive) const {
    const json::json_pointer path("/extensions/KHR_draco_mesh_compression/attributes");
    return primitive.contains(path) && primitive[path].contains(name_);
  }

  const GltfDocument& known_;
  json document_;
  const std::string& name_;
};

}  // namespace

Result<FaceWeights> read_face_weights(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                      const ImportOptions& options, const std::string& attribute) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const bool is_glb = text.starts_with("glTF");
  // What is wrong with the file is found here, and its faces.
  const auto mesh =
      decode_gltf(bytes, is_glb ? MeshFormat::glb : MeshFormat::gltf, limits, options);
  if (!mesh) return fail(mesh.error());
  const auto container = is_glb ? open_glb(bytes) : open_gltf(bytes);
  if (!container) return fail(container.error());
  const auto known = parse_gltf(container->json, limits);
  if (!known) return fail(known.error());
  const std::uint64_t max_decompressed = 12 * (limits.max_vertices + limits.max_faces);
  GltfBuffers buffers(*known, container->binary, container->has_binary, max_decompressed);
  const auto drawn = find_drawn(*known, buffers, options, limits, bytes.size());
  if (!drawn) return fail(drawn.error());
  auto document = json::parse(container->json, nullptr, /*allow_exceptions=*/false);
  if (!document.is_object()) {
    return fail(ErrorCode::mesh_invalid, "The glTF's JSON does not parse, or is not an object.");
  }
  const Attributes attributes(*known, std::move(document), attribute);

  std::vector<float> of_vertex(mesh->soup.positions.size());
  std::map<std::size_t, GltfElements> read;  // by accessor: primitives are drawn many times
  for (const DrawnPrimitive& one : *drawn) {
    if (!draws_triangles(known->meshes[one.mesh].primitives[one.primitive])) continue;
    const auto accessor = attributes.accessor_of(one);
    if (!accessor) return fail(accessor.error());
    // Before it is read: elements that no bytes stand for may be as many as it says.
    const GltfAccessor& claimed = known->accessors[*accessor];
    if (claimed.components != 1 || claimed.count != one.vertices ||
        one.first_vertex + one.vertices > of_vertex.size()) {
      return no_weights(primitive_name(one) + ": its attribute " + attribute +
                        " is not one number for each of its vertices");
    }
    auto elements = read.find(*accessor);
    if (elements == read.end()) {
      auto found = read_accessor(*known, buffers, *accessor, GltfUse::any, bytes.size());
      if (!found) return fail(std::move(found.error()));
      elements = read.emplace(*accessor, std::move(*found)).first;
    }
    const GltfElements& values = elements->second;
    for (std::uint64_t i = 0; i < one.vertices; ++i) {
      of_vertex[one.first_vertex + i] = static_cast<float>(values.number(i, 0));
    }
  }
  FaceWeights weights;
  weights.by_face.reserve(mesh->soup.faces.size());
  for (const Triangle& face : mesh->soup.faces) {
    double sum = 0;
    for (const std::uint32_t v : face) {
      const double weight = of_vertex[v];
      if (!(weight >= kLeastWeight && weight <= kMostWeight)) {
        std::string number;
        append_number(number, weight, 6);
        return no_weights(attribute + " is " + number + " at vertex " + std::to_string(v) +
                          ", and a weight is from 1e-9 to 1e9; what must not be walked on is "
                          "forbidden by forbid");
      }
      sum += weight;
    }
    weights.by_face.push_back(sum / 3);
  }
  return weights;
}

}  // namespace geodesic::proto
