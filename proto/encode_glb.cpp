#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "proto/encode_mesh.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

// Little-endian, as all of glTF.
void put_u32(std::byte* at, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) at[i] = static_cast<std::byte>(value >> (8 * i));
}

void append_u32(std::vector<std::byte>& bytes, std::uint32_t value) {
  bytes.resize(bytes.size() + 4);
  put_u32(bytes.data() + bytes.size() - 4, value);
}

std::uint32_t bits_of(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

}  // namespace

std::vector<std::byte> encode_glb(const TriangleSoup& soup, const std::string& name) {
  const std::size_t vertices = soup.positions.size();
  const std::size_t position_bytes = 12 * vertices;
  const std::size_t index_bytes = 12 * soup.faces.size();
  json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "geodesicd"}};
  document["scene"] = 0;
  document["scenes"][0]["nodes"] = json::array({0});
  document["nodes"][0]["name"] = name;
  std::array<float, 3> low;
  std::array<float, 3> high;
  low.fill(std::numeric_limits<float>::infinity());
  high.fill(-std::numeric_limits<float>::infinity());
  // glTF allows no empty accessor: without triangles there is only the node.
  const bool drawn = !soup.faces.empty() && vertices != 0;
  std::vector<std::byte> binary(drawn ? position_bytes + index_bytes : 0);
  if (drawn) {
    std::byte* at = binary.data();
    for (const Vec3& p : soup.positions) {
      const float xyz[3] = {static_cast<float>(p.x), static_cast<float>(p.y),
                            static_cast<float>(p.z)};
      for (std::size_t i = 0; i < 3; ++i, at += 4) {
        low[i] = std::min(low[i], xyz[i]);
        high[i] = std::max(high[i], xyz[i]);
        put_u32(at, bits_of(xyz[i]));
      }
    }
    for (const auto& face : soup.faces) {
      for (const std::uint32_t vertex : face) {
        put_u32(at, vertex);
        at += 4;
      }
    }
    constexpr int array_buffer = 34962;
    constexpr int element_array_buffer = 34963;
    document["buffers"][0]["byteLength"] = binary.size();
    document["bufferViews"][0] = {
        {"buffer", 0}, {"byteOffset", 0}, {"byteLength", position_bytes}, {"target", array_buffer}};
    document["bufferViews"][1] = {{"buffer", 0},
                                  {"byteOffset", position_bytes},
                                  {"byteLength", index_bytes},
                                  {"target", element_array_buffer}};
    document["accessors"][0] = {{"bufferView", 0},   {"componentType", 5126},
                                {"count", vertices}, {"type", "VEC3"},
                                {"min", low},        {"max", high}};
    document["accessors"][1] = {{"bufferView", 1},
                                {"componentType", 5125},
                                {"count", 3 * soup.faces.size()},
                                {"type", "SCALAR"}};
    json& mesh = document["meshes"][0];
    mesh["name"] = name;
    mesh["primitives"][0]["attributes"]["POSITION"] = 0;
    mesh["primitives"][0]["indices"] = 1;
    mesh["primitives"][0]["mode"] = 4;
    document["nodes"][0]["mesh"] = 0;
  }
  std::string text = document.dump(-1, ' ', false, json::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');

  std::vector<std::byte> glb;
  const std::size_t total = 12 + 8 + text.size() + (drawn ? 8 + binary.size() : 0);
  glb.reserve(total);
  append_u32(glb, 0x46546C67);  // "glTF"
  append_u32(glb, 2);
  append_u32(glb, static_cast<std::uint32_t>(total));
  append_u32(glb, static_cast<std::uint32_t>(text.size()));
  append_u32(glb, 0x4E4F534A);  // "JSON"
  const auto* text_bytes = reinterpret_cast<const std::byte*>(text.data());
  glb.insert(glb.end(), text_bytes, text_bytes + text.size());
  if (drawn) {
    append_u32(glb, static_cast<std::uint32_t>(binary.size()));
    append_u32(glb, 0x004E4942);  // "BIN\0"
    glb.insert(glb.end(), binary.begin(), binary.end());
  }
  return glb;
}

}  // namespace geodesic::proto
