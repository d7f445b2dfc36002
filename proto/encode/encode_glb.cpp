#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <variant>

#include "proto/encode/encode_mesh.h"
#include "proto/encode/glb_drawing.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr int kFloat = 5126;
constexpr int kUnsignedInt = 5125;
constexpr int kUnsignedByte = 5121;

// Little-endian, as all of glTF.
void append_u32(std::vector<std::byte>& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i)));
}

std::uint32_t bits_of(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

// glTF's vertex colours are linear, colour maps are sRGB.
std::uint8_t linear(std::uint8_t channel) {
  const double s = channel / 255.0;
  const double l = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  return static_cast<std::uint8_t>(std::lround(255 * l));
}

// The document and its binary chunk, growing part by part.
class GlbWriter {
 public:
  explicit GlbWriter(Poll* poll) : poll_(poll) {
    document_["asset"] = {{"version", "2.0"}, {"generator", "geodesicd"}};
    document_["scene"] = 0;
    document_["scenes"][0] = json::object();  // without `nodes` where there are none
  }

  void add(const GlbPart& part) {
    const std::size_t node = document_["scenes"][0]["nodes"].size();
    document_["scenes"][0]["nodes"].push_back(node);
    document_["nodes"][node]["name"] = part.name;
    for (const auto& [name, number] : part.extras) {
      json& extra = document_["nodes"][node]["extras"][name];
      std::visit([&](auto value) { extra = value; }, number);
    }
    // glTF allows no empty accessor: without positions there is only the node.
    if (part.positions.empty()) return;
    json primitive{{"mode", static_cast<int>(part.mode)}};
    primitive["attributes"]["POSITION"] = add_positions(part.positions);
    if (!part.colours.empty()) primitive["attributes"]["COLOR_0"] = add_colours(part.colours);
    if (!part.texture.empty()) {
      primitive["attributes"]["TEXCOORD_0"] = add_texture_coordinates(part.texture);
    }
    if (!part.directions.empty()) {
      primitive["attributes"][kDirectionAttribute] = add_positions(part.directions);
    }
    if (!part.indices.empty()) primitive["indices"] = add_indices(part.indices);
    if (!part.colours.empty() || part.mode == GlbPart::Mode::line_strip) {
      primitive["material"] = unlit_material();
    } else if (!part.texture.empty()) {
      primitive["material"] = textured_material();
    }
    const std::size_t mesh = document_["meshes"].size();
    document_["meshes"].push_back({{"name", part.name}, {"primitives", json::array({primitive})}});
    document_["nodes"][node]["mesh"] = mesh;
  }

  [[nodiscard]] std::vector<std::byte> finish() {
    if (!binary_.empty()) document_["buffers"][0]["byteLength"] = binary_.size();
    std::string text = document_.dump(-1, ' ', false, json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> glb;
    const std::size_t total = 12 + 8 + text.size() + (binary_.empty() ? 0 : 8 + binary_.size());
    glb.reserve(total);
    append_u32(glb, 0x46546C67);  // "glTF"
    append_u32(glb, 2);
    append_u32(glb, static_cast<std::uint32_t>(total));
    append_u32(glb, static_cast<std::uint32_t>(text.size()));
    append_u32(glb, 0x4E4F534A);  // "JSON"
    const auto* text_bytes = reinterpret_cast<const std::byte*>(text.data());
    glb.insert(glb.end(), text_bytes, text_bytes + text.size());
    if (!binary_.empty()) {
      append_u32(glb, static_cast<std::uint32_t>(binary_.size()));
      append_u32(glb, 0x004E4942);  // "BIN\0"
      glb.insert(glb.end(), binary_.begin(), binary_.end());
    }
    return glb;
  }

 private:
  // Every accessor's bytes are a multiple of four: nothing needs padding.
  std::size_t add_accessor(std::size_t begin, int target, json accessor) {
    const std::size_t view = document_["bufferViews"].size();
    document_["bufferViews"].push_back({{"buffer", 0},
                                        {"byteOffset", begin},
                                        {"byteLength", binary_.size() - begin},
                                        {"target", target}});
    accessor["bufferView"] = view;
    document_["accessors"].push_back(std::move(accessor));
    return document_["accessors"].size() - 1;
  }

  std::size_t add_positions(const std::vector<Vec3>& positions) {
    const std::size_t begin = binary_.size();
    std::array<float, 3> low;
    std::array<float, 3> high;
    low.fill(std::numeric_limits<float>::infinity());
    high.fill(-std::numeric_limits<float>::infinity());
    binary_.reserve(begin + 12 * positions.size());
    for (const Vec3& p : positions) {
      if (is_stopped()) break;
      const float xyz[3] = {static_cast<float>(p.x), static_cast<float>(p.y),
                            static_cast<float>(p.z)};
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], xyz[i]);
        high[i] = std::max(high[i], xyz[i]);
        append_u32(binary_, bits_of(xyz[i]));
      }
    }
    return add_accessor(begin, kArrayBuffer,
                        {{"componentType", kFloat},
                         {"count", positions.size()},
                         {"type", "VEC3"},
                         {"min", low},
                         {"max", high}});
  }

  std::size_t add_colours(const std::vector<Colour>& colours) {
    const std::size_t begin = binary_.size();
    for (const Colour& colour : colours) {
      if (is_stopped()) break;
      for (const std::uint8_t channel : colour) {
        binary_.push_back(static_cast<std::byte>(linear(channel)));
      }
      binary_.push_back(std::byte{255});
    }
    return add_accessor(begin, kArrayBuffer,
                        {{"componentType", kUnsignedByte},
                         {"normalized", true},
                         {"count", colours.size()},
                         {"type", "VEC4"}});
  }

  std::size_t add_texture_coordinates(const std::vector<std::array<float, 2>>& coordinates) {
    const std::size_t begin = binary_.size();
    for (const auto& [u, v] : coordinates) {
      if (is_stopped()) break;
      append_u32(binary_, bits_of(u));
      append_u32(binary_, bits_of(v));
    }
    return add_accessor(
        begin, kArrayBuffer,
        {{"componentType", kFloat}, {"count", coordinates.size()}, {"type", "VEC2"}});
  }

  std::size_t add_indices(const std::vector<std::uint32_t>& indices) {
    const std::size_t begin = binary_.size();
    for (const std::uint32_t index : indices) {
      if (is_stopped()) break;
      append_u32(binary_, index);
    }
    return add_accessor(
        begin, kElementArrayBuffer,
        {{"componentType", kUnsignedInt}, {"count", indices.size()}, {"type", "SCALAR"}});
  }

  std::size_t unlit_material() {
    document_["extensionsUsed"] = {"KHR_materials_unlit"};
    return add_material(
        unlit_, {{"name", "unlit"}, {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  }

  // Without a material, readers drop texture coordinates.
  std::size_t textured_material() { return add_material(textured_, {{"name", "textured"}}); }

  // White on both sides; its number, once it is there.
  std::size_t add_material(std::optional<std::size_t>& number, json material) {
    if (!number) {
      number = document_["materials"].size();
      material["doubleSided"] = true;
      material["pbrMetallicRoughness"] = {{"baseColorFactor", {1, 1, 1, 1}}, {"metallicFactor", 0}};
      document_["materials"].push_back(std::move(material));
    }
    return *number;
  }

  [[nodiscard]] bool is_stopped() { return poll_ != nullptr && poll_->cancelled(); }

  std::optional<std::size_t> unlit_;
  std::optional<std::size_t> textured_;
  Poll* poll_;  // may be null
  json document_;
  std::vector<std::byte> binary_;
};

}  // namespace

std::vector<std::byte> encode_glb_parts(std::span<const GlbPart> parts, Poll* poll) {
  GlbWriter writer(poll);
  for (const GlbPart& part : parts) {
    if (poll != nullptr && poll->cancelled()) return {};
    writer.add(part);
  }
  if (poll != nullptr && poll->ask()) return {};
  return writer.finish();
}

std::vector<std::byte> encode_glb(const TriangleSoup& soup, const std::string& name) {
  GlbPart part{name, GlbPart::Mode::triangles, {}, {}, {}, {}, {}};
  if (!soup.faces.empty()) {
    part.positions = soup.positions;
    part.indices.reserve(3 * soup.faces.size());
    for (const auto& face : soup.faces) {
      part.indices.insert(part.indices.end(), face.begin(), face.end());
    }
  }
  return encode_glb_parts(std::span(&part, 1));
}

}  // namespace geodesic::proto
