// What spoiled or hostile files are refused with: a code, and a message that
// names the fault.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "proto/encode/encode_mesh.h"
#include "proto/gltf_file/container.h"
#include "proto/wire/input_codes.h"
#include "tests/bench/processor_time.h"
#include "tests/proto/gltf/honest_file.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

TEST_CASE("an index out of range is refused, naming primitive, accessor and value") {
  auto f = one_triangle();
  const auto indices = f.indices({0, 1, 2, 0, 1, 3});
  f.document["meshes"][0]["primitives"][0]["indices"] = indices;
  check_refused(f, ErrorCode::index_out_of_range,
                "mesh 0, primitive 0: accessor 2: index 5 is 3, but there are 3 vertices");
}

TEST_CASE("the primitive restart value is refused as such") {
  auto f = one_triangle();
  const auto indices = f.indices({0, 1, 2, 0xFFFF, 0, 1});
  f.document["meshes"][0]["primitives"][0] = GltfFixture::primitive(0, 5, indices);
  check_refused(f, ErrorCode::index_out_of_range, "primitive restart");
}

TEST_CASE("positions that are not finite are refused, naming accessor and element") {
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
    GltfFixture f;
    f.mesh({GltfFixture::primitive(f.positions({0, 0, 0, 1, 0, 0, 0, bad, 0}))});
    f.node({{"mesh", 0}});
    check_refused(f, invalid, "accessor 0: position 2 is not finite");
  }
}

TEST_CASE("a transform that leaves the range of numbers is refused, naming the node") {
  auto f = one_triangle();
  f.document["nodes"][0]["scale"] = {1e200, 1, 1};
  f.node({{"children", {0}}, {"scale", {1e200, 1, 1}}});
  check_refused(f, invalid, "node 0");
}

// glTF 2.0 says that names in an object must be unique; parsers take the first or the last.
TEST_CASE("a name that comes twice in any object of the JSON is refused, naming it") {
  auto f = one_triangle();
  f.document["extras"] = {{"deep", {{"inside", json::array({{{"of", 1}}})}}}};
  f.document["buffers"] =
      json::array({{{"byteLength", f.binary.size()},
                    {"uri", "data:application/octet-stream;base64," + base64(f.binary)}}});
  const std::string text = f.document.dump();
  REQUIRE(decode(bytes_of(text)));
  int spoiled = 0;
  for (std::size_t at = text.find("{\""); at != std::string::npos; at = text.find("{\"", at + 1)) {
    const std::string name = text.substr(at + 2, text.find('"', at + 2) - at - 2);
    std::string twice = text;
    twice.insert(at + 1, "\"" + name + "\":null,");
    CAPTURE(twice);
    for (const auto& got : {decode(bytes_of(twice)), decode(glb_of(twice, {}))}) {
      REQUIRE_FALSE(got);
      CHECK(got.error().code == invalid);
      CHECK(got.error().detail == "The glTF's JSON has the name " + name + " twice in one object.");
    }
    ++spoiled;
  }
  CHECK(spoiled >= 10);
}

TEST_CASE("files without triangles are told so") {
  GltfFixture empty;
  check_refused(empty, ErrorCode::no_triangles, "no triangles");
  auto lines = one_triangle();
  lines.document["meshes"][0]["primitives"][0]["mode"] = 1;
  check_refused(lines, ErrorCode::no_triangles, "no triangles");
  auto two_vertices = one_triangle();
  two_vertices.document["accessors"][1]["count"] = 2;
  check_refused(two_vertices, ErrorCode::no_triangles, "no triangles");
  auto elsewhere = one_triangle();
  elsewhere.document["scenes"] = json::array({{{"nodes", json::array()}}});
  check_refused(elsewhere, ErrorCode::no_triangles, "no triangles");
}

TEST_CASE("nodes that contain themselves are refused") {
  check_refused(spoiled("/nodes/0/children", {0}), invalid, "node 0 is among its own");
  auto f = one_triangle();
  f.node({{"children", {2}}});
  f.node({{"children", {3}}});
  f.node({{"children", {1}}});
  check_refused(f, invalid, "node 1 is among its own");
}

TEST_CASE("a hierarchy that doubles at every level ends at the limit of nodes") {
  auto f = one_triangle();
  for (int i = 0; i < 60; ++i) f.node({{"children", {i, i}}});
  DecodeLimits limits;
  limits.max_nodes = 10'000;
  check_refused(f, ErrorCode::too_large, "too many nodes", limits);
}

TEST_CASE("a very deep hierarchy is walked without a stack") {
  auto f = one_triangle();
  for (int i = 0; i < 100'000; ++i) f.node({{"children", {i}}});
  const auto mesh = decode(f.glb());
  REQUIRE(mesh.has_value());
  CHECK(mesh->parts.size() == 1);
}

TEST_CASE("claims beyond the bytes present are refused before memory is taken") {
  constexpr auto huge = std::uint64_t{1} << 52;
  DecodeLimits limits;
  limits.max_vertices = ~std::uint64_t{0};
  limits.max_faces = ~std::uint64_t{0};
  check_refused(spoiled("/accessors/0/count", 2'000'000'000), invalid, "accessor 0 reaches",
                limits);
  check_refused(spoiled("/accessors/1/count", huge), invalid, "accessor 1 reaches", limits);
  check_refused(spoiled("/accessors/0/byteOffset", huge), invalid, "accessor 0 reaches");
  check_refused(spoiled("/accessors/0/byteOffset", 1), invalid, "accessor 0 reaches to byte 37");
  check_refused(spoiled("/bufferViews/0/byteLength", huge), invalid, "bufferView 0 reaches");
  check_refused(spoiled("/bufferViews/1/byteOffset", huge), invalid, "bufferView 1 reaches");
  check_refused(spoiled("/buffers", {{{"byteLength", huge}}}).glb(), invalid, "buffer 0 claims");
  auto sparse = one_triangle();
  sparse.document["accessors"][0] = {{"componentType", 5126},
                                     {"count", 1'000'000},
                                     {"type", "VEC3"},
                                     {"sparse",
                                      {{"count", 1},
                                       {"indices", {{"bufferView", 1}, {"componentType", 5121}}},
                                       {"values", {{"bufferView", 0}}}}}};
  check_refused(sparse, invalid, "accessor 0 claims 1000000 elements");
}

TEST_CASE("the limits of vertices and faces hold, instances counted") {
  auto f = one_triangle();
  for (int i = 0; i < 9; ++i) f.node({{"mesh", 0}});
  DecodeLimits limits;
  limits.max_vertices = 29;
  check_refused(f, ErrorCode::too_many_vertices, "too many vertices", limits);
  limits.max_vertices = 30;
  limits.max_faces = 9;
  check_refused(f, ErrorCode::too_many_faces, "too many faces", limits);
  limits.max_faces = 10;
  CHECK(decode_mesh(f.glb(), limits).has_value());
}

TEST_CASE("two thousand buffers over one chunk cost nothing") {
  auto f = one_triangle();
  f.binary.resize(1'000'000);
  f.document["buffers"] = json::array();
  for (int i = 0; i < 2000; ++i) f.document["buffers"].push_back({{"byteLength", f.binary.size()}});
  CHECK(decode(f.glb()).has_value());
  f.document["bufferViews"][0]["buffer"] = 1;
  check_refused(f.glb(), invalid, "buffer 1 has no data");
}

TEST_CASE("other files are never opened") {
  for (const char* uri : {"mesh.bin", "../../etc/passwd", "file:///etc/passwd", "/dev/zero", "",
                          "https://example.org/mesh.bin"}) {
    CAPTURE(uri);
    check_refused(spoiled("/buffers", {{{"byteLength", 44}, {"uri", uri}}}),
                  InputCode::external_uri, "buffer 0");
  }
}

TEST_CASE("data URIs that are not base64 are refused") {
  const auto with = [](const char* uri) {
    return spoiled("/buffers", {{{"byteLength", 3}, {"uri", uri}}});
  };
  check_refused(with("data:application/octet-stream,abc"), invalid, "not in base64");
  check_refused(with("data:;base64"), invalid, "not in base64");
  check_refused(with("data:;base64,AA!A"), invalid, "not valid base64");
  check_refused(with("data:;base64,AAAAA"), invalid, "not valid base64");
}

TEST_CASE("extensions that move vertices are refused by name") {
  for (const char* name : {"MPEG_media", "KHR_gaussian_splatting", "ACME_bend"}) {
    check_refused(spoiled("/extensionsRequired", {name}), InputCode::extension_required, name);
  }
}

TEST_CASE("JSON nested too deep is refused before a parser recurses") {
  for (const char* nest : {"[", "{\"a\":"}) {
    std::string text = "{\"asset\":{\"version\":\"2.0\"},\"extras\":";
    for (int i = 0; i < 200'000; ++i) text += nest;
    check_refused(bytes_of(text), invalid, "nested too deep");
    check_refused(glb_of(text, {}), invalid, "nested too deep");
  }
  // Brackets in strings are not nesting.
  std::string brackets(1000, '[');
  CHECK(decode(spoiled("/extras", brackets + "\\\"" + brackets).gltf()).has_value());
}

TEST_CASE("JSON of very many values is refused before it is parsed") {
  std::string text = "{\"asset\":{\"version\":\"2.0\"},\"extras\":[0";
  for (int i = 0; i < 100; ++i) text += ",0";
  text += "]}";
  DecodeLimits limits;
  limits.max_json_values = 50;
  check_refused(bytes_of(text), ErrorCode::too_large, "too many values", limits);
  limits.max_json_values = 5000;
  check_refused(bytes_of(text), ErrorCode::no_triangles, "no triangles", limits);
}

TEST_CASE("a string without an end is refused before it is parsed, whatever comes before it") {
  std::string before = R"({"asset":{"version":"2.0"},"extras":["closed\\")";
  for (int i = 0; i < 100; ++i) before += ",0";
  before += ',';
  DecodeLimits limits;
  limits.max_json_values = 50;
  for (const char* open : {R"(")", R"("x)", R"("x\")", R"("x\\\")", R"("x\\\"y)"}) {
    const std::string text = before + open;
    CAPTURE(text);
    const std::string named = "byte " + std::to_string(before.size() + 1) + ", where a string";
    check_refused(bytes_of(text), invalid, named, limits);
    check_refused(glb_of(text, {}), invalid, named, limits);
    CHECK_FALSE(check_json_shape(text, DecodeLimits{}).has_value());
  }
}

TEST_CASE("a document that lists too many objects is refused before it is parsed further") {
  auto f = one_triangle();  // 1 mesh, 1 primitive, 1 node, 2 views, 2 accessors, 1 buffer
  DecodeLimits limits;
  limits.max_gltf_objects = 8;
  CHECK(decode_mesh(f.glb(), limits).has_value());
  limits.max_gltf_objects = 7;
  check_refused(f, ErrorCode::too_large, "lists too many", limits);
}

TEST_CASE("properties of the wrong type or range are refused, naming the object") {
  const auto check = [](const char* pointer, const json& value, const char* named) {
    CAPTURE(pointer);
    check_refused(spoiled(pointer, value), invalid, named);
  };
  check("/asset/version", "1.0", "version 1.0");
  check("/nodes", 7, "nodes is not an array");
  check("/nodes/0", 7, "nodes: element 0");
  check("/nodes/0/mesh", 1, "node 0");
  check("/nodes/0/mesh", -1, "node 0");
  check("/nodes/0/children", {99}, "node 0");
  check("/nodes/0/matrix", {1, 2, 3}, "node 0");
  check("/nodes/0/matrix", {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "node 0");
  check("/scene", 0, "scene");
  check("/meshes/0/primitives/0/mode", 7, "mesh 0, primitive 0");
  check("/meshes/0/primitives/0/indices", 4294967297, "mesh 0, primitive 0");
  check("/meshes/0/primitives/0/attributes", {1}, "mesh 0, primitive 0");
  check("/meshes/0/primitives/0/attributes/POSITION", 9, "mesh 0, primitive 0");
  check("/accessors/0/count", 0, "accessor 0");
  check("/accessors/0/count", "3", "accessor 0");
  check("/accessors/0/count", 2.5, "accessor 0");
  check("/accessors/0/type", "VEC2", "accessor 0");
  check("/accessors/0/type", "VEC5", "accessor 0");
  check("/accessors/0/componentType", 5124, "accessor 0");
  check("/accessors/1/componentType", 5126, "accessor 1");
  check("/accessors/0/bufferView", 2, "accessor 0");
  check("/bufferViews/0/byteStride", 8, "accessor 0");
  check("/bufferViews/0/byteStride", 13, "bufferView 0");
  check("/bufferViews/0/buffer", 1, "bufferView 0");
}

TEST_CASE("an accessor without bytes can't hold positions or indices") {
  for (const char* accessor : {"/accessors/0", "/accessors/1"}) {
    auto f = one_triangle();
    f.document[json::json_pointer(accessor)].erase("bufferView");
    check_refused(f, invalid, "has no bufferView");
  }
}

TEST_CASE("headers and chunks of a GLB that lie about lengths are refused") {
  const auto good = one_triangle().glb();
  const auto with = [&](std::size_t at, std::uint32_t value) {
    Bytes bytes = good;
    for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::byte>(value >> (8 * i));
    return bytes;
  };
  check_refused(with(4, 1), invalid, "version 1");
  check_refused(with(8, 0xFFFFFFFF), invalid, "header claims 4294967295");
  check_refused(with(8, 4), invalid, "header claims 4");
  check_refused(with(12, 0xFFFFFFFF), invalid, "chunk 0 claims 4294967295");
  check_refused(with(16, 0x004E4942), invalid, "chunk 0 is not the JSON chunk");
  const auto json_size = good.size() - 12 - 8 - 8 - 44;
  check_refused(with(12 + 8 + json_size, 52), invalid, "chunk 1 claims 52");
}

TEST_CASE("a Draco header that claims too much is refused before it is decoded") {
  const auto header = [](int method, const std::vector<std::uint8_t>& counts) {
    Bytes bytes = bytes_of("DRACO");
    for (const int byte : {2, 2, 1, method, 0, 0}) bytes.push_back(static_cast<std::byte>(byte));
    for (const std::uint8_t byte : counts) bytes.push_back(static_cast<std::byte>(byte));
    bytes.resize(64);
    return bytes;
  };
  const std::vector<std::uint8_t> million = {0xC0, 0x84, 0x3D};
  const double begin = bench::processor_ms();
  // sequential: faces, points
  check_refused(header(0, {1, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F}), ErrorCode::too_many_vertices, "");
  check_refused(header(0, {0xFF, 0xFF, 0xFF, 0xFF, 0x0F, 3}), ErrorCode::too_many_faces, "");
  check_refused(header(0, {1, million[0], million[1], million[2]}), invalid, "1000000 points");
  check_refused(header(0, {0, 0}), ErrorCode::no_triangles, "no triangles");
  check_refused(header(0, {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}), invalid, "ends within");
  // edgebreaker: traversal, vertices, faces, attributes, symbols, splits
  check_refused(header(1, {0, 3, 1, 0, 1, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F}), invalid, "contradict");
  check_refused(header(1, {0, 3, 1, 0, 2, 0}), invalid, "contradict");
  check_refused(header(1, {0, 4, 1, 0, 1, 0}), invalid, "contradict");
  check_refused(header(1, {0, 3, 100, 255, 1, 0}), invalid, "100 faces");
  const double taken = bench::processor_ms() - begin;
  CHECK(taken < ms_of_honest_file());
}

TEST_CASE("Draco metadata nested without end is refused") {
  Bytes bytes = bytes_of("DRACO");
  for (const int byte : {2, 2, 1, 0, 0, 0x80, 0}) bytes.push_back(static_cast<std::byte>(byte));
  for (int i = 0; i < 1'000'000; ++i) {
    for (const int byte : {0, 1, 0}) bytes.push_back(static_cast<std::byte>(byte));
  }
  check_refused(bytes, invalid, "ends within");
}

TEST_CASE("a Draco point cloud has no triangles") {
  Bytes bytes = bytes_of("DRACO");
  for (const int byte : {2, 3, 0, 0, 0, 0, 9}) bytes.push_back(static_cast<std::byte>(byte));
  check_refused(bytes, ErrorCode::no_triangles, "point cloud");
}
