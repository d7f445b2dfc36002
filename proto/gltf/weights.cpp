#include "proto/gltf/weights.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <tuple>
#include <utility>

#include "proto/draco/codec.h"
#include "proto/gltf/accessor.h"
#include "proto/gltf/decode.h"
#include "proto/gltf/drawn.h"
#include "proto/gltf/geometry.h"
#include "proto/gltf_file/buffers.h"
#include "proto/gltf_file/container.h"
#include "proto/gltf_file/parse.h"
#include "proto/wire/number.h"
#include "proto/wire/query_limits.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

constexpr const char* kWeightParameter = "weight_attribute";
// Of names in a message.
constexpr std::size_t kMostNamesTold = 20;
constexpr std::uint64_t kGreatestId = std::numeric_limits<std::uint32_t>::max();

tl::unexpected<Error> no_numbers(std::string detail) {
  return fail(ErrorCode::value_out_of_range, std::move(detail));
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

// Reads the attribute of a name, primitive by primitive, each place that has numbers once.
class AttributeReader {
 public:
  AttributeReader(const GltfDocument& known, GltfBuffers& buffers, json document,
                  const std::string& name, const DecodeLimits& limits, std::uint64_t file_bytes)
      : known_(known),
        buffers_(buffers),
        document_(std::move(document)),
        name_(name),
        draco_limits_{limits.max_vertices, limits.max_faces},
        file_bytes_(file_bytes) {}

  // A number for each vertex of a primitive.
  [[nodiscard]] Result<void> read(const DrawnPrimitive& one, std::span<double> out) {
    const json& primitive = document_["meshes"][one.mesh]["primitives"][one.primitive];
    const auto accessor = accessor_of(one, primitive);
    if (!accessor) return fail(accessor.error());
    if (known_.accessors[*accessor].components != 1) return not_one_each(one);
    const auto& draco = known_.meshes[one.mesh].primitives[one.primitive].draco;
    const json::json_pointer path("/extensions/KHR_draco_mesh_compression/attributes");
    if (draco && primitive.contains(path) && primitive[path].contains(name_)) {
      return from_draco(one, draco->view, primitive[path][name_], *accessor, out);
    }
    return from_accessor(one, *accessor, out);
  }

 private:
  // The accessor of the one that was asked for.
  [[nodiscard]] Result<std::size_t> accessor_of(const DrawnPrimitive& one,
                                                const json& primitive) const {
    static const json none = json::object();
    const auto given = primitive.find("attributes");
    const json& attributes = given != primitive.end() && given->is_object() ? *given : none;
    const auto found = attributes.find(name_);
    if (found == attributes.end()) {
      return no_numbers(primitive_name(one) + " has no attribute " + name_ +
                        "; it has: " + names_of(attributes));
    }
    if (!found->is_number_unsigned() || found->get<std::uint64_t>() >= known_.accessors.size()) {
      return no_numbers(primitive_name(one) + ": its attribute " + name_ +
                        " names an accessor that there is not");
    }
    return found->get<std::size_t>();
  }

  [[nodiscard]] tl::unexpected<Error> not_one_each(const DrawnPrimitive& one) const {
    return no_numbers(primitive_name(one) + ": its attribute " + name_ +
                      " is not one number for each of its vertices");
  }

  Result<void> from_accessor(const DrawnPrimitive& one, std::size_t accessor,
                             std::span<double> out) {
    // Before it is read: elements that no bytes stand for may be as many as it says.
    if (known_.accessors[accessor].count != one.vertices) return not_one_each(one);
    auto elements = elements_.find(accessor);
    if (elements == elements_.end()) {
      auto found = read_accessor(known_, buffers_, accessor, GltfUse::any, file_bytes_);
      if (!found) return fail(std::move(found.error()));
      elements = elements_.emplace(accessor, std::move(*found)).first;
    }
    const GltfElements& values = elements->second;
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = values.number(i, 0);
    }
    return {};
  }

  // As with positions, how many there are is what the bitstream says, not the accessor.
  Result<void> from_draco(const DrawnPrimitive& one, std::size_t view, const json& id,
                          std::size_t accessor, std::span<double> out) {
    if (!id.is_number_unsigned() || id.get<std::uint64_t>() > kGreatestId) {
      return no_numbers(primitive_name(one) + ": its attribute " + name_ +
                        " has no id in the Draco data");
    }
    const DracoAttribute attribute{id.get<std::uint32_t>(), known_.accessors[accessor].normalized};
    auto& numbers = draco_[{view, attribute.unique_id, attribute.normalized}];
    if (numbers.empty()) {
      const auto bytes = buffers_.view(view);
      if (!bytes) return fail(bytes.error());
      auto decoded = decode_draco_numbers(*bytes, draco_limits_, attribute);
      if (!decoded && decoded.error().code == ErrorCode::mesh_invalid) {
        // Positions have been read from the same bytes.
        return no_numbers(primitive_name(one) + ": its attribute " + name_ +
                          " cannot be read: " + decoded.error().detail);
      }
      if (!decoded) return fail(std::move(decoded.error()));
      numbers = std::move(*decoded);
    }
    if (numbers.size() != out.size()) return not_one_each(one);
    std::ranges::copy(numbers, out.begin());
    return {};
  }

  const GltfDocument& known_;
  GltfBuffers& buffers_;
  json document_;
  const std::string& name_;
  DracoLimits draco_limits_;
  std::uint64_t file_bytes_;
  // Primitives are drawn many times, and may share what they are made of.
  std::map<std::size_t, GltfElements> elements_;  // by accessor
  std::map<std::tuple<std::size_t, std::uint32_t, bool>, std::vector<double>> draco_;
};

// By vertex of the mesh, of which each drawn primitive has its own.
struct VertexNumbers {
  std::vector<Triangle> faces;
  std::vector<double> of_vertex;
};

Result<VertexNumbers> read_vertex_numbers(std::span<const std::byte> bytes,
                                          const DecodeLimits& limits, const ImportOptions& options,
                                          const std::string& attribute) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const bool is_glb = text.starts_with("glTF");
  // What is wrong with the file is found here, and its faces.
  auto mesh = decode_gltf(bytes, is_glb ? MeshFormat::glb : MeshFormat::gltf, limits, options);
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
  AttributeReader reader(*known, buffers, std::move(document), attribute, limits, bytes.size());
  VertexNumbers numbers{std::move(mesh->soup.faces), {}};
  numbers.of_vertex.resize(mesh->soup.positions.size());
  for (const DrawnPrimitive& one : *drawn) {
    if (!draws_triangles(known->meshes[one.mesh].primitives[one.primitive])) continue;
    if (one.first_vertex + one.vertices > numbers.of_vertex.size()) {
      return no_numbers(primitive_name(one) + " has other vertices than were decoded");
    }
    const std::span<double> out =
        std::span(numbers.of_vertex).subspan(one.first_vertex, one.vertices);
    if (const auto read = reader.read(one, out); !read) return fail(read.error());
  }
  return numbers;
}

// The mean of the weights at the corners.
Result<double> weight_of(const Triangle& face, const std::vector<double>& of_vertex,
                         const std::string& attribute) {
  double sum = 0;
  for (const std::uint32_t v : face) {
    const double weight = static_cast<float>(of_vertex[v]);
    if (!(weight >= kLeastWeight && weight <= kMostWeight)) {
      std::string number = "no finite number";
      if (std::isfinite(weight)) {
        number.clear();
        append_number(number, weight, 6);
      }
      return no_numbers(attribute + " is " + number + " at vertex " + std::to_string(v) +
                        ", and a weight is from 1e-9 to 1e9; what must not be walked on is "
                        "forbidden by forbid");
    }
    sum += weight;
  }
  return sum / 3;
}

double label_of(const Triangle& face, const std::vector<double>& of_vertex) {
  const double label = of_vertex[face[0]];
  const bool is_common = of_vertex[face[1]] == label && of_vertex[face[2]] == label;
  return is_common ? label : std::numeric_limits<double>::quiet_NaN();
}

Result<FaceNumbers> numbers_of_faces(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                     const ImportOptions& options, const std::string& attribute,
                                     FaceNumber which) {
  const auto numbers = read_vertex_numbers(bytes, limits, options, attribute);
  if (!numbers) return fail(numbers.error());
  FaceNumbers all;
  all.by_face.reserve(numbers->faces.size());
  for (const Triangle& face : numbers->faces) {
    if (which == FaceNumber::label) {
      all.by_face.push_back(label_of(face, numbers->of_vertex));
      continue;
    }
    const auto weight = weight_of(face, numbers->of_vertex, attribute);
    if (!weight) return fail(weight.error());
    all.by_face.push_back(*weight);
  }
  return all;
}

}  // namespace

Result<FaceNumbers> read_face_numbers(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                      const ImportOptions& options, const std::string& attribute,
                                      FaceNumber which) {
  auto numbers = numbers_of_faces(bytes, limits, options, attribute, which);
  if (numbers || which != FaceNumber::weight) return numbers;
  if (numbers.error().code == ErrorCode::value_out_of_range) {
    numbers.error().parameter = kWeightParameter;
  }
  return numbers;
}

}  // namespace geodesic::proto
