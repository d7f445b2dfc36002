// glTF files with everything that a pipeline may have put in, drawn at random: several nodes and
// scenes, meshes that nodes share, primitives of all kinds, interleaved views, Draco data,
// materials, animations, extras.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/draco/codec.h"
#include "proto/encode/encode_mesh.h"

namespace geodesic::server::test {

using nlohmann::ordered_json;

class RandomScene {
 public:
  enum class Container : std::uint8_t { glb, glb_with_uri, gltf };

  explicit RandomScene(std::mt19937& random) : random_(random) {
    document_ = {{"asset", {{"version", "2.0"}, {"generator", "a pipeline"}}}, {"scene", 0}};
    document_["extras"] = {{"zeta", 1.5}, {"alpha", {1, "two", nullptr}}, {"größe", "\n\u00e9"}};
    for (const char* array : {"scenes", "nodes", "meshes", "accessors", "bufferViews"}) {
      document_[array] = ordered_json::array();
    }
    document_["materials"] = {{{"name", "red"}, {"extras", {{"id", 7}}}},
                              {{"name", "glass, 50%; a:b*c + \"d\" \u00e4"}},
                              {{"name", "red"}},
                              {{"alphaMode", "BLEND"}}};
    document_["cameras"] = {
        {{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.01}}}}};
    const int meshes = pick(1, 4);
    for (int m = 0; m < meshes; ++m) add_mesh(m == 0);
    add_nodes(meshes);
  }

  [[nodiscard]] const ordered_json& document() const { return document_; }

  [[nodiscard]] std::string file(Container container) const {
    ordered_json document = document_;
    ordered_json buffer{{"byteLength", binary_.size()}, {"name", "all"}};
    if (container != Container::glb) {
      buffer["uri"] = "data:application/octet-stream;base64," + base64(binary_);
    }
    document["buffers"] = ordered_json::array({buffer});
    std::string json = document.dump(container == Container::gltf ? 2 : -1);
    if (container == Container::gltf) return json;
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string chunks;
    append_chunk(chunks, "JSON", json);
    std::string binary = binary_;
    binary.resize((binary.size() + 3) / 4 * 4);
    if (container == Container::glb) append_chunk(chunks, std::string("BIN\0", 4), binary);
    append_chunk(chunks, "XTRA", "somebody's");
    std::string glb = "glTF";
    append_u32(glb, 2);
    append_u32(glb, 12 + chunks.size());
    return glb + chunks + "behind the end";
  }

 private:
  int pick(int least, int most) { return std::uniform_int_distribution<int>(least, most)(random_); }
  float number() { return std::uniform_real_distribution<float>(-1, 1)(random_); }

  static void append_u32(std::string& out, std::size_t value) {
    for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> (8 * i) & 0xFF);
  }
  static void append_chunk(std::string& out, const std::string& type, std::string bytes) {
    bytes.resize((bytes.size() + 3) / 4 * 4, ' ');
    append_u32(out, bytes.size());
    out += type + bytes;
  }
  static std::string base64(const std::string& bytes) {
    constexpr char kAlphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
      std::uint32_t bits = 0;
      for (std::size_t j = 0; j < 3; ++j) {
        bits = bits << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0u);
      }
      for (std::size_t j = 0; j < 4; ++j) {
        text += i + j <= bytes.size() ? kAlphabet[bits >> (18 - 6 * j) & 63] : '=';
      }
    }
    return text;
  }

  std::size_t add(const char* array, ordered_json item) {
    document_[array].push_back(std::move(item));
    return document_[array].size() - 1;
  }
  std::size_t view(const std::string& bytes, std::size_t stride = 0) {
    binary_.resize((binary_.size() + 3) / 4 * 4);
    ordered_json view{{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes.size()}};
    if (stride != 0) view["byteStride"] = stride;
    binary_ += bytes;
    return add("bufferViews", std::move(view));
  }
  template <class T>
  static std::string bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
  }

  TriangleSoup patch() {
    TriangleSoup soup = shapes::plane(static_cast<std::uint32_t>(pick(2, 5)),
                                      static_cast<std::uint32_t>(pick(2, 5)));
    for (Vec3& p : soup.positions) p.z = 0.3 * static_cast<double>(number());
    for (Vec3& p : soup.positions) p = {float(p.x), float(p.y), float(p.z)};
    return soup;
  }

  ordered_json attributes_of(const TriangleSoup& soup) {
    const bool interleaved = pick(0, 1) == 1;
    std::vector<float> data;
    for (const Vec3& p : soup.positions) {
      data.insert(data.end(), {float(p.x), float(p.y), float(p.z)});
      if (interleaved) data.insert(data.end(), {0, 0, 1});
    }
    const std::size_t v = view(bytes_of(data), interleaved ? 24 : 0);
    ordered_json accessor{{"bufferView", v},
                          {"componentType", 5126},
                          {"count", soup.positions.size()},
                          {"type", "VEC3"}};
    ordered_json attributes{{"POSITION", add("accessors", accessor)}};
    if (!interleaved) return attributes;
    accessor["byteOffset"] = 12;
    attributes["NORMAL"] = add("accessors", accessor);
    return attributes;
  }

  ordered_json plain_primitive(const TriangleSoup& soup, bool has_indices) {
    if (!has_indices) {
      TriangleSoup apart;
      for (const Triangle& face : soup.faces) {
        for (const std::uint32_t v : face) apart.positions.push_back(soup.positions[v]);
      }
      return {{"attributes", attributes_of(apart)}};
    }
    std::vector<std::uint16_t> corners;
    for (const Triangle& face : soup.faces) {
      for (const std::uint32_t v : face) corners.push_back(static_cast<std::uint16_t>(v));
    }
    ordered_json primitive{{"attributes", attributes_of(soup)}};
    primitive["indices"] = add("accessors", {{"bufferView", view(bytes_of(corners))},
                                             {"componentType", 5123},
                                             {"count", corners.size()},
                                             {"type", "SCALAR"}});
    return primitive;
  }

  ordered_json draco_primitive(const TriangleSoup& soup) {
    const auto drc = proto::encode_drc(soup, 0).value();
    const auto decoded = proto::decode_draco(drc, {1000, 1000}).value();
    const std::size_t count = decoded.positions.size();
    ordered_json primitive{
        {"attributes",
         {{"POSITION",
           add("accessors", {{"componentType", 5126}, {"count", count}, {"type", "VEC3"}})}}}};
    primitive["indices"] =
        add("accessors",
            {{"componentType", 5123}, {"count", 3 * decoded.faces.size()}, {"type", "SCALAR"}});
    primitive["extensions"] = {
        {"KHR_draco_mesh_compression",
         {{"bufferView", view({reinterpret_cast<const char*>(drc.data()), drc.size()})},
          {"attributes", {{"POSITION", 0}}}}}};
    document_["extensionsUsed"] = {"KHR_draco_mesh_compression"};
    document_["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    return primitive;
  }

  void add_mesh(bool has_surface) {
    ordered_json primitives = ordered_json::array();
    const int count = pick(1, 3);
    for (int i = 0; i < count; ++i) {
      const TriangleSoup soup = patch();
      const int kind = has_surface && i == 0 ? pick(0, 3) : pick(0, 6);
      ordered_json primitive = kind == 3 ? draco_primitive(soup) : plain_primitive(soup, kind != 1);
      if (kind >= 4) {
        primitive.erase("indices");
        primitive["mode"] = kind == 4 ? 0 : kind == 5 ? 3 : 5;  // points, a line, a strip
      }
      if (pick(0, 4) > 0) primitive["material"] = pick(0, 3);
      primitive["extras"] = {{"part", i}};
      primitives.push_back(std::move(primitive));
    }
    add("meshes", {{"primitives", primitives}, {"extras", {{"weight", number()}}}});
  }

  // A forest, the first scene of which draws the first mesh; the second one has the last node.
  void add_nodes(int meshes) {
    const int count = pick(1, 6);
    std::vector<std::vector<std::size_t>> children(static_cast<std::size_t>(count));
    std::vector<std::size_t> roots{0};
    for (int n = 1; n < count; ++n) {
      const int parent = pick(-1, n - 1);
      (parent < 0 ? roots : children[static_cast<std::size_t>(parent)])
          .push_back(static_cast<std::size_t>(n));
    }
    for (int n = 0; n < count; ++n) {
      ordered_json node{{"name", "node " + std::to_string(n)}};
      if (n == 0 || pick(0, 3) > 0) node["mesh"] = n == 0 ? 0 : pick(0, meshes - 1);
      if (pick(0, 1) == 1) node["translation"] = {number(), number(), 20.0 * n};
      if (pick(0, 1) == 1) node["scale"] = {1 + 0.5 * double(number()), 2, 1};
      if (pick(0, 2) == 0) node["rotation"] = {0, 0.6, 0, 0.8};
      if (pick(0, 2) == 0) node["camera"] = 0;
      const auto& own = children[static_cast<std::size_t>(n)];
      if (!own.empty()) node["children"] = own;
      document_["nodes"].push_back(std::move(node));
    }
    // Drawn by no scene, or by another one.
    add("nodes", {{"mesh", pick(0, meshes - 1)}, {"name", "elsewhere"}});
    add("scenes", {{"nodes", roots}, {"name", "all"}});
    if (pick(0, 1) == 1) add("scenes", {{"nodes", {count}}});
  }

  std::mt19937& random_;
  ordered_json document_;
  std::string binary_;
};

}  // namespace geodesic::server::test
