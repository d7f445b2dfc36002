// Small glTF files made in code, valid unless a test spoils them: `document` is
// open to any change before `glb()` or `gltf()` writes it down.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "proto/formats/decode_mesh.h"

namespace geodesic::proto {

using Bytes = std::vector<std::byte>;
using nlohmann::json;

inline Bytes bytes_of(std::string_view text) {
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  return {data, data + text.size()};
}

template <class T>
Bytes bytes_of(const std::vector<T>& values) {
  const auto* data = reinterpret_cast<const std::byte*>(values.data());
  return {data, data + values.size() * sizeof(T)};
}

inline std::string base64(const Bytes& bytes) {
  constexpr std::string_view alphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      bits = bits << 8 | (i + j < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + j]) : 0);
    }
    for (std::size_t j = 0; j < 4; ++j) {
      text += i + j <= bytes.size() ? alphabet[bits >> (18 - 6 * j) & 63] : '=';
    }
  }
  return text;
}

inline void append_u32(Bytes& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i)));
}

// A GLB of these two chunks, padded; without `binary` there is one chunk.
inline Bytes glb_of(std::string text, Bytes binary) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4);
  Bytes glb = bytes_of("glTF");
  append_u32(glb, 2);
  const std::size_t chunks = binary.empty() ? 8 : 16;
  append_u32(glb, static_cast<std::uint32_t>(12 + chunks + text.size() + binary.size()));
  append_u32(glb, static_cast<std::uint32_t>(text.size()));
  append_u32(glb, 0x4E4F534A);
  for (const char c : text) glb.push_back(static_cast<std::byte>(c));
  if (binary.empty()) return glb;
  append_u32(glb, static_cast<std::uint32_t>(binary.size()));
  append_u32(glb, 0x004E4942);
  glb.insert(glb.end(), binary.begin(), binary.end());
  return glb;
}

struct GltfFixture {
  json document = {{"asset", {{"version", "2.0"}}},
                   {"bufferViews", json::array()},
                   {"accessors", json::array()},
                   {"meshes", json::array()},
                   {"nodes", json::array()}};
  Bytes binary;

  std::size_t view(const Bytes& bytes, std::size_t stride = 0) {
    binary.resize((binary.size() + 3) / 4 * 4);
    json view = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}};
    if (stride != 0) view["byteStride"] = stride;
    binary.insert(binary.end(), bytes.begin(), bytes.end());
    return add("bufferViews", std::move(view));
  }

  std::size_t accessor(std::size_t view, int component, std::size_t count, const char* type) {
    return add(
        "accessors",
        {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
  }

  std::size_t positions(const std::vector<float>& xyz) {
    return accessor(view(bytes_of(xyz)), 5126, xyz.size() / 3, "VEC3");
  }

  std::size_t indices(const std::vector<std::uint16_t>& values) {
    return accessor(view(bytes_of(values)), 5123, values.size(), "SCALAR");
  }

  std::size_t mesh(const std::vector<json>& primitives) {
    return add("meshes", {{"primitives", primitives}});
  }

  static json primitive(std::size_t position, int mode = 4) {
    return {{"attributes", {{"POSITION", position}}}, {"mode", mode}};
  }

  static json primitive(std::size_t position, int mode, std::size_t indices) {
    return {{"attributes", {{"POSITION", position}}}, {"mode", mode}, {"indices", indices}};
  }

  std::size_t node(json properties) { return add("nodes", std::move(properties)); }

  std::size_t add(const char* array, json item) {
    document[array].push_back(std::move(item));
    return document[array].size() - 1;
  }

  [[nodiscard]] Bytes glb() const {
    json copy = document;
    if (!binary.empty() && !copy.contains("buffers")) {
      copy["buffers"] = json::array({{{"byteLength", binary.size()}}});
    }
    return glb_of(copy.dump(), binary);
  }

  [[nodiscard]] Bytes gltf() const {
    json copy = document;
    if (!binary.empty() && !copy.contains("buffers")) {
      copy["buffers"] =
          json::array({{{"byteLength", binary.size()},
                        {"uri", "data:application/octet-stream;base64," + base64(binary)}}});
    }
    return bytes_of(copy.dump());
  }
};

// One right triangle in the plane z = 0, indexed.
inline GltfFixture one_triangle() {
  GltfFixture f;
  const auto position = f.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  f.mesh({GltfFixture::primitive(position, 4, f.indices({0, 1, 2}))});
  f.node({{"mesh", 0}});
  return f;
}

inline Result<DecodedMesh> decode(const Bytes& bytes) { return decode_mesh(bytes, DecodeLimits{}); }

// What a valid file decodes to, as GLB and as glTF alike.
inline DecodedMesh decoded(const GltfFixture& fixture) {
  auto mesh = decode(fixture.glb());
  if (!mesh) FAIL(mesh.error().detail);
  auto same = decode(fixture.gltf());
  if (!same) FAIL(same.error().detail);
  CHECK(same->soup.positions == mesh->soup.positions);
  CHECK(same->soup.faces == mesh->soup.faces);
  CHECK(mesh->format == MeshFormat::glb);
  CHECK(same->format == MeshFormat::gltf);
  return *mesh;
}

inline bool warns_of(const DecodedMesh& mesh, const std::string& what) {
  return std::ranges::any_of(mesh.findings, [&](const Finding& finding) {
    return finding.text.find(what) != std::string::npos;
  });
}

inline void check_close(const std::vector<Vec3>& got, const std::vector<Vec3>& expected,
                        double tolerance = 1e-12) {
  REQUIRE(got.size() == expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    CAPTURE(i);
    CHECK(distance(got[i], expected[i]) < tolerance);
  }
}

inline void check_refused(const Bytes& bytes, ErrorCode code, const std::string& named,
                          const DecodeLimits& limits = {}) {
  const auto mesh = decode_mesh(bytes, limits);
  REQUIRE_FALSE(mesh.has_value());
  CAPTURE(mesh.error().detail);
  CHECK(mesh.error().code.name() == code.name());
  CHECK(mesh.error().detail.find(named) != std::string::npos);
}

inline void check_refused(const GltfFixture& f, ErrorCode code, const std::string& named,
                          const DecodeLimits& limits = {}) {
  check_refused(f.glb(), code, named, limits);
  check_refused(f.gltf(), code, named, limits);
}

// One triangle with one property set to something else.
inline GltfFixture spoiled(const char* pointer, const json& value) {
  auto f = one_triangle();
  f.document[json::json_pointer(pointer)] = value;
  return f;
}

inline constexpr auto invalid = ErrorCode::mesh_invalid;

}  // namespace geodesic::proto
