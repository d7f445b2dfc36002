#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/encode/encode_mesh.h"
#include "server/decoder/decoded_frame.h"
#include "tests/fuzz/targets.h"
#include "tests/proto/gltf_file/draco_fixture.h"
#include "tests/proto/gltf_file/fixture.h"

namespace geodesic::fuzz {
namespace {

using nlohmann::json;
using proto::Bytes;
using proto::GltfFixture;

std::string text_of(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <class T>
void append_bytes(std::string& out, const T& value) {
  const auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  out.append(bytes.data(), bytes.size());
}

std::vector<std::pair<std::string, TriangleSoup>> small_shapes() {
  return {{"plane", shapes::plane(4, 3)},           {"sphere", shapes::icosphere(1)},
          {"knot", shapes::torus_knot(12, 3, 0.3)}, {"saddle", shapes::saddle(5, 2)},
          {"terrain", shapes::terrain(6, 2, 1)},    {"square", shapes::plane(2, 2)}};
}

// Strips, fans, points and lines, with indices of each width and without.
GltfFixture with_every_mode() {
  GltfFixture file;
  const auto corners = file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, 2, 1, 3, 1, 0});
  const auto bytes = file.accessor(
      file.view(proto::bytes_of(std::vector<std::uint8_t>{0, 1, 2, 3, 4, 5})), 5121, 6, "SCALAR");
  const auto words = file.accessor(
      file.view(proto::bytes_of(std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5})), 5125, 6, "SCALAR");
  std::vector<json> primitives;
  for (int mode = 0; mode <= 6; ++mode) {
    primitives.push_back(GltfFixture::primitive(corners, mode));
    primitives.push_back(GltfFixture::primitive(corners, mode, bytes));
    primitives.push_back(GltfFixture::primitive(corners, mode, words));
  }
  file.mesh(primitives);
  file.node({{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 2, 0, 5, 6, 7, 1}}});
  return file;
}

GltfFixture with_sparse_and_quantised() {
  auto file = proto::one_triangle();
  const auto strip = file.positions({0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0});
  const auto places = file.view(proto::bytes_of(std::vector<std::uint8_t>{1}));
  const auto values = file.view(proto::bytes_of(std::vector<float>{3, 3, 3}));
  file.document["accessors"][strip]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", places}, {"componentType", 5121}}},
      {"values", {{"bufferView", values}}}};
  const auto quantised = file.accessor(
      file.view(proto::bytes_of(std::vector<std::int16_t>{0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0}), 8),
      5122, 3, "VEC3");
  file.document["extensionsUsed"] = {"KHR_mesh_quantization"};
  file.document["extensionsRequired"] = {"KHR_mesh_quantization"};
  file.mesh({GltfFixture::primitive(strip, 5), GltfFixture::primitive(quantised)});
  file.node({{"mesh", 1}, {"children", {0}}, {"scale", {1, 2, 3}}, {"rotation", {0, 0, 1, 0}}});
  file.document["materials"] = {{{"name", "glass"}}, json::object(), {{"name", "\u00e4"}}};
  file.document["meshes"][1]["primitives"][0]["material"] = 2;
  file.document["meshes"][1]["primitives"][1]["material"] = 7;
  file.document["scenes"] = json::array({{{"nodes", {1}}}});
  file.document["scene"] = 0;
  return file;
}

// An icosphere with a number at each corner of its faces.
proto::DracoNumbers sphere_numbers(int component_type, bool by_edgebreaker) {
  proto::DracoNumbers numbers;
  numbers.component_type = component_type;
  numbers.bits = component_type == 5126 ? 8 : 0;
  numbers.by_edgebreaker = by_edgebreaker;
  const std::size_t corners = 3 * shapes::icosphere(1).faces.size();
  for (std::size_t i = 0; i < corners; ++i) {
    numbers.at_corner.push_back(1 + static_cast<double>(i / 3 % 3));
  }
  return numbers;
}

GltfFixture with_draco() {
  GltfFixture file;
  std::vector<json> primitives;
  for (const int component_type : {5126, 5123}) {
    const proto::DracoNumbers numbers = sphere_numbers(component_type, true);
    primitives.push_back(proto::draco_primitive(
        file, proto::draco_of(shapes::icosphere(1), numbers), numbers, "_MUD"));
  }
  file.mesh(primitives);
  file.node({{"mesh", 0}});
  return file;
}

// What is asked comes before the mesh: so many bytes, here each by a step from the one before.
std::vector<std::string> before_meshes(std::size_t bytes) {
  std::vector<std::string> seeds;
  unsigned step = 37;
  for (const std::string& mesh : mesh_seeds()) {
    std::string question;
    for (std::size_t i = 0; i < bytes; ++i) {
      question += static_cast<char>((i + 1) * step & 255U);
    }
    seeds.push_back(question + mesh.substr(1));
    step += 22;
  }
  return seeds;
}

}  // namespace

std::vector<std::string> gltf_seeds() {
  std::vector<std::string> seeds;
  for (const auto& [name, soup] : small_shapes()) {
    seeds.push_back(text_of(proto::encode_glb(soup, name)));
  }
  for (const GltfFixture& file :
       {proto::one_triangle(), with_every_mode(), with_sparse_and_quantised(), with_draco()}) {
    seeds.push_back(text_of(file.glb()));
    seeds.push_back(text_of(file.gltf()));
  }
  return seeds;
}

std::vector<std::string> draco_seeds() {
  std::vector<std::string> seeds;
  for (const auto& [name, soup] : small_shapes()) {
    for (const int bits : {0, 8, 14}) {
      if (auto file = proto::encode_drc(soup, bits)) seeds.push_back(text_of(*file));
    }
  }
  for (const int component_type : {5126, 5121, 5125}) {
    for (const bool by_edgebreaker : {true, false}) {
      seeds.push_back(text_of(
          proto::draco_of(shapes::icosphere(1), sphere_numbers(component_type, by_edgebreaker))
              .bytes));
    }
  }
  return seeds;
}

std::vector<std::string> polygon_seeds() {
  std::vector<std::string> seeds{
      "o a\nv 0 0 0\nv 1 0 0\nv 1 1e0 0 # c\nv -.5 2 0.25\nvn 0 0 1\ns 1\nf 1//1 2/3/1 \\\n 3 "
      "-1\nl 1 2\n",
      "ply\r\nformat ascii 1.0\r\ncomment\r\nelement face 2\r\nproperty uchar k\r\n"
      "property list uchar int vertex_index\r\nelement vertex 4\r\nproperty float x\r\n"
      "property double z\r\nproperty int y\r\nproperty float q\r\nelement edge 1\r\nproperty int "
      "a\r\nend_header\r\n"
      "7 3 0 1 2\r\n7 4 0 1 2 3\r\n0 0 0 1\r\n1 0 0 nan\r\n1 1e-3 1 1e-50\r\n0 0.5 2 -0\r\n5",
  };
  for (const auto& [name, soup] : small_shapes()) {
    std::string binary =
        "ply\nformat binary_little_endian 1.0\nobj_info i\nelement vertex " +
        std::to_string(soup.positions.size()) +
        "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
        std::to_string(soup.faces.size()) +
        "\nproperty list uchar uint vertex_indices\nproperty short k\nend_header\n";
    std::string facets(80, ' ');
    append_bytes(facets, static_cast<std::uint32_t>(soup.faces.size()));
    std::string text = "solid " + name + "\n";
    for (const Vec3& p : soup.positions) append_bytes(binary, p);
    for (const auto& face : soup.faces) {
      binary += '\3';
      append_bytes(binary, face);
      append_bytes(binary, std::int16_t{-2});
      facets.append(12, '\0');
      text += "facet normal 0 0 1\nouter loop\n";
      for (const std::uint32_t v : face) {
        const Vec3& p = soup.positions[v];
        for (const double x : {p.x, p.y, p.z}) append_bytes(facets, static_cast<float>(x));
        text += "vertex " + std::to_string(p.x) + " " + std::to_string(p.y) + " " +
                std::to_string(p.z) + "\n";
      }
      facets.append(2, '\0');
      text += "endloop\nendfacet\n";
    }
    seeds.insert(seeds.end(), {binary, facets, text + "endsolid\n"});
  }
  return seeds;
}

std::vector<std::string> mesh_seeds() {
  using namespace std::string_literals;
  return {
      // Vertices and faces as small_soup.h reads them.
      "\x05\x01\x00\x10\x01\x21\x02\x33\x03\x44\x00\x15\x01\x26\x00\x01\x02\x02\x01\x03\x04\x05\x06"s,
      "\x13\x00\x00\x00\x01\x00\x02\x00\x08\x00\x09\x00\x0a\x00\x10\x00\x11\x00\x12\x00"s,
      "\x15\x02\x70\x71\x72\x73\x74\x75\x76\x77\x78\x79\x7a\x7b\x7c\x7d\x7e\x7f\x01\x02\x03"s,
      std::string(60, '\x07'),
  };
}

std::vector<std::string> heap_seeds() {
  // As heaps.cpp reads them: how thin and flat, what faces share, how many of both.
  return {std::string(8, '\0'), "heap", std::string(16, '\x5a'), std::string(24, '\xff')};
}

std::vector<std::string> line_seeds() { return before_meshes(37); }
std::vector<std::string> wall_seeds() { return before_meshes(48); }
std::vector<std::string> cost_seeds() { return before_meshes(71); }

std::vector<std::string> request_seeds() {
  return {
      R"({"from":"v:0","to":{"face":4,"bary":[0.2,0.3,0.5]},"method":"exact","refine":"shortest"})",
      R"({"from":[{"vertex":1,"offset":2.5},"p:1,2,3"],"max":9.5,"labels":true,"format":"frame"})",
      R"({"from":"curve:closed;v:1;v:2;v:3","signed":true,"format":"f32"})",
      R"({"from":[{"boundary":0},{"curve":{"points":["v:1","v:7"]}},"faces:0-3"],"to":["v:9"],"stream":true})",
      R"({"from":["v:0"],"levels":[1,2,3],"precision":6})",
      R"({"from":"v:0","direction":[1,0,0],"length":3})",
      R"({"point":[{"ray":{"origin":[0,0,9],"direction":[0,0,-1]}}]})",
      R"({"count":1,"within":[{"faces":[7,[1,9]]},{"part":2}],"forbid":{"sphere":{"center":[1,2,3],"radius":1}}})",
      R"({"count":1,"forbid":[{"box":{"min":[1,2,3],"max":[4,5,6]}},"faces:0-9"]})",
      "from=v:0&from=v:1&from=v:2&rows=1-2&stream=1&format=npy",
      R"({"from":["v:0","v:1","v:2"],"rows":"1-","sparse":true,"max":2,"format":"npz"})",
      R"({"count":1,"walls":[{"points":["v:0",{"xyz":[1,2,3]}]},"v:1;f:2,0.3,0.3"],"forbid":{"inside":["v:0","v:1",{"vertex":2}]}})",
      "count=1&walls=v:0;p:1,2,3;v:0&walls=ray:0,0,9,0,0,-1;v:2&within=inside:v:0;v:1;v:2",
      R"({"from":"v:0","to":"v:9","weights":[{"weight":3,"region":{"faces":[7,[1,9]]}},"2*part:0"],"slope":[[-1,2],[1,3]]})",
      R"({"from":"v:0","face_weights":[1,2,3],"slope":"tobler","steepest":0.6,"up":[0,0,1]})",
      "from=v:0&to=v:9&weights=3*faces:7,10-99&weights=2*sphere:1,2,3,0.5&slope=-0.5:2,0:1,0.5:3&"
      "up=0,0,1",
      "from=v:0&to=v:9&weight_attribute=_MUD&slope=tobler",
      "count=1&within=faces:7,10-99&within=part:2&forbid=sphere:1,2,3,0.5&forbid=box:0,0,0,1,2,3",
      "count=1&within=material:glass&within=material:3&forbid=material:none&forbid=label:_SEG=3&"
      "forbid=part:%22a%22",
      R"({"from":[{"part":"roof"},{"material":null},{"label":{"attribute":"_SEG","value":1.5}}],"weights":["2*material:a*b;c",{"weight":3,"region":{"material":"\u00e4"}}]})",
      R"({"through":["v:0","v:9",{"vertex":5}],"format":"glb"})",
      R"({"around":["v:0",{"face":4,"bary":[0.2,0.3,0.5]},"v:7"],"closed":true})",
      "at=v:5&normal=0,0,1&hull=1&format=f64",
      "from=v:5&radius=2.5&angle=0.3&transport=1&format=glb",
      "of=diameter&fields=8&format=annotated",
      R"({"of":"means","fields":16,"format":"f32"})",
      R"({"from":["v:0","v:9",{"curve":{"points":["v:1","v:7"]}}],"relax":3,"part":"delaunay"})",
      "from=v:0&radii=1&radii=2.5&levels=3&format=glb",
      "from=v:0&from=v:1&to=v:2&to=boundary&landmarks=20&stream=1&format=npy",
      "from=v:0&slope=energy&steepest=0.6&attribute=_GEODESIC_A&format=annotated",
      "from=v:0&to=v:9&via=f:1,0.2,0.3&refine=none&precision=6",
      "from=v:0&from=p:1,2,3&at=v:1&max=2e3&method=steiner&points_per_edge=5",
      "from=v%3A0&count=10&step=0.5&angle=1.5&length=2",
  };
}

std::vector<std::string> point_seeds() {
  return {"v:12",
          "f:40,0.2,0.3",
          "p:1,-2.5e3,3",
          "ray:0,0,9,0,0,-1",
          R"({"vertex":12,"offset":1})",
          R"({"face":40,"bary":[0.2,0.3,0.5]})",
          R"({"xyz":[1,2,3],"max_snap":0.1})",
          R"({"ray":{"origin":[0,0,9],"direction":[0,0,-1]}})"};
}

std::vector<std::string> frame_seeds() {
  std::vector<std::string> seeds;
  const auto add = [&](const auto& answer) {
    Bytes frame(server::frame_size(answer));
    server::write_frame(answer, frame);
    seeds.push_back(text_of(frame));
  };
  for (const std::string& file : gltf_seeds()) {
    add(proto::decode_mesh(proto::bytes_of(file), {}));
  }
  add(server::Decoded(fail_limit(ErrorCode::too_large, "too large", 5, 6, "from")));
  add(Result<server::FormFile>(server::FormFile{"a.glb", "bytes"}));
  seeds.push_back(server::write_order({}));
  return seeds;
}

}  // namespace geodesic::fuzz
