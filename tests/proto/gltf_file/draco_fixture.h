// Draco data with numbers at the corners of its faces, by Draco's own encoder, and the glTF
// primitive that says where they are.
#pragma once

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/mesh/triangle_soup.h"
#include "tests/proto/gltf_file/fixture.h"

namespace geodesic::proto {

struct DracoNumbers {
  int component_type = 5126;      // glTF's
  std::vector<double> at_corner;  // three for each face
  int bits = 0;                   // floats are quantised to; 0: not at all
  bool by_edgebreaker = true;
  std::uint32_t position_id = 0;
  std::uint32_t number_id = 1;
  bool says_normalized = false;  // in the Draco data; glTF goes by the accessor
};

struct DracoFixture {
  Bytes bytes;
  std::uint32_t points = 0;
  std::uint32_t faces = 0;
};

inline draco::DataType draco_type(int component_type) {
  switch (component_type) {
    case 5121:
      return draco::DT_UINT8;
    case 5123:
      return draco::DT_UINT16;
    case 5125:
      return draco::DT_UINT32;
    default:
      return draco::DT_FLOAT32;
  }
}

// One number as bytes of a type of glTF.
inline std::array<std::byte, 4> number_of_type(double number, int component_type) {
  std::array<std::byte, 4> bytes{};
  const auto put = [&](auto value) { std::memcpy(bytes.data(), &value, sizeof value); };
  switch (component_type) {
    case 5121:
      put(static_cast<std::uint8_t>(number));
      break;
    case 5123:
      put(static_cast<std::uint16_t>(number));
      break;
    case 5125:
      put(static_cast<std::uint32_t>(number));
      break;
    default:
      put(static_cast<float>(number));
  }
  return bytes;
}

// Positions are not quantised. Corners of one position and one number are one point.
inline DracoFixture draco_of(const TriangleSoup& soup, const DracoNumbers& numbers) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(soup.faces.size()));
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int number = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 1,
                                          draco_type(numbers.component_type));
  for (std::uint32_t f = 0; f < soup.faces.size(); ++f) {
    std::array<std::array<float, 3>, 3> xyz{};
    std::array<std::array<std::byte, 4>, 3> values{};
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3& p = soup.positions[soup.faces[f][c]];
      xyz[c] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
      values[c] = number_of_type(numbers.at_corner[3 * f + c], numbers.component_type);
    }
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(f), xyz[0].data(), xyz[1].data(),
                                      xyz[2].data());
    builder.SetAttributeValuesForFace(number, draco::FaceIndex(f), values[0].data(),
                                      values[1].data(), values[2].data());
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  mesh->attribute(position)->set_unique_id(numbers.position_id);
  mesh->attribute(number)->set_unique_id(numbers.number_id);
  mesh->attribute(number)->set_normalized(numbers.says_normalized);
  draco::Encoder encoder;
  encoder.SetEncodingMethod(numbers.by_edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING
                                                   : draco::MESH_SEQUENTIAL_ENCODING);
  if (numbers.bits > 0) {
    encoder.SetAttributeQuantization(draco::GeometryAttribute::GENERIC, numbers.bits);
  }
  encoder.SetTrackEncodedProperties(true);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(*mesh, &buffer).ok()) FAIL("Draco does not encode this");
  return {bytes_of(std::string_view(buffer.data(), buffer.size())),
          static_cast<std::uint32_t>(encoder.num_encoded_points()),
          static_cast<std::uint32_t>(encoder.num_encoded_faces())};
}

// A primitive of the data, whose numbers are called `name`.
inline json draco_primitive(GltfFixture& f, const DracoFixture& draco, const DracoNumbers& numbers,
                            const std::string& name) {
  const auto accessor = [&](int component, std::uint32_t count, const char* type) {
    return f.add("accessors", {{"componentType", component}, {"count", count}, {"type", type}});
  };
  json primitive = GltfFixture::primitive(accessor(5126, draco.points, "VEC3"), 4,
                                          accessor(5125, 3 * draco.faces, "SCALAR"));
  primitive["attributes"][name] = accessor(numbers.component_type, draco.points, "SCALAR");
  primitive["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", f.view(draco.bytes)},
      {"attributes", {{"POSITION", numbers.position_id}, {name, numbers.number_id}}}};
  f.document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return primitive;
}

}  // namespace geodesic::proto
