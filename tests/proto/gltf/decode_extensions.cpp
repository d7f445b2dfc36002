// Extensions and features that change where vertices are: meshopt compression, GPU
// instancing, morph targets. Answers by hand, and by decoding the same geometry
// without the extension.
#include <meshoptimizer.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "proto/wire/input_codes.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

constexpr auto malformed = ErrorCode::mesh_invalid;

// A grid of n x n vertices in the plane z = x * y / n, x and y whole numbers.
struct Grid {
  std::vector<float> xyz;
  std::vector<std::uint32_t> corners;
};

Grid grid(std::uint32_t n) {
  Grid g;
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const auto z = static_cast<float>(x * y) / static_cast<float>(n);
      g.xyz.insert(g.xyz.end(), {static_cast<float>(x), static_cast<float>(y), z});
    }
  }
  for (std::uint32_t y = 0; y + 1 < n; ++y) {
    for (std::uint32_t x = 0; x + 1 < n; ++x) {
      const std::uint32_t v = y * n + x;
      g.corners.insert(g.corners.end(), {v, v + 1, v + n, v + 1, v + n + 1, v + n});
    }
  }
  return g;
}

Bytes cut_to(std::vector<unsigned char> bytes, std::size_t size) {
  REQUIRE(size > 0);
  bytes.resize(size);
  return bytes_of(bytes);
}

Bytes encoded_vertices(const Bytes& plain, std::size_t count, std::size_t stride) {
  std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
  const auto size = meshopt_encodeVertexBuffer(out.data(), out.size(), plain.data(), count, stride);
  return cut_to(out, size);
}

Bytes encoded_triangles(const std::vector<std::uint32_t>& corners, std::size_t vertices) {
  std::vector<unsigned char> out(meshopt_encodeIndexBufferBound(corners.size(), vertices));
  const auto size =
      meshopt_encodeIndexBuffer(out.data(), out.size(), corners.data(), corners.size());
  return cut_to(out, size);
}

Bytes encoded_sequence(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
  std::vector<unsigned char> out(meshopt_encodeIndexSequenceBound(indices.size(), vertices));
  const auto size =
      meshopt_encodeIndexSequence(out.data(), out.size(), indices.data(), indices.size());
  return cut_to(out, size);
}

// A view that is to be decompressed: its own buffer has no data.
std::size_t compressed_view(GltfFixture& f, const Bytes& compressed, std::size_t count,
                            std::size_t stride, const char* mode,
                            const char* extension = "EXT_meshopt_compression") {
  const auto at = f.view(compressed);
  const json place = f.document["bufferViews"][at];
  f.document["bufferViews"][at] = {{"buffer", 1},
                                   {"byteLength", count * stride},
                                   {"extensions",
                                    {{extension,
                                      {{"buffer", 0},
                                       {"byteOffset", place["byteOffset"]},
                                       {"byteLength", place["byteLength"]},
                                       {"byteStride", stride},
                                       {"count", count},
                                       {"mode", mode}}}}}};
  return at;
}

json& meshopt_of(GltfFixture& f, std::size_t view) {
  return f.document["bufferViews"][view]["extensions"]["EXT_meshopt_compression"];
}

// The GLB alone: its second buffer is a place to decompress to and has no data.
Bytes file_of(GltfFixture f) {
  f.document["buffers"] = {{{"byteLength", f.binary.size()}},
                           {{"byteLength", 1'000'000},
                            {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  f.document["extensionsRequired"] = {"EXT_meshopt_compression", "KHR_mesh_quantization"};
  return f.glb();
}

// The grid, positions and triangles compressed.
GltfFixture compressed_grid(const Grid& g) {
  GltfFixture f;
  const std::size_t count = g.xyz.size() / 3;
  const auto vertices =
      compressed_view(f, encoded_vertices(bytes_of(g.xyz), count, 12), count, 12, "ATTRIBUTES");
  const auto faces =
      compressed_view(f, encoded_triangles(g.corners, count), g.corners.size(), 4, "TRIANGLES");
  const auto position = f.accessor(vertices, 5126, count, "VEC3");
  f.mesh(
      {GltfFixture::primitive(position, 4, f.accessor(faces, 5125, g.corners.size(), "SCALAR"))});
  f.node({{"mesh", 0}});
  return f;
}

TriangleSoup plain_soup(const Grid& g) {
  TriangleSoup soup;
  for (std::size_t i = 0; i < g.xyz.size(); i += 3) {
    soup.positions.push_back({g.xyz[i], g.xyz[i + 1], g.xyz[i + 2]});
  }
  for (std::size_t i = 0; i < g.corners.size(); i += 3) {
    soup.faces.push_back({g.corners[i], g.corners[i + 1], g.corners[i + 2]});
  }
  return soup;
}

void check_refuses(const Bytes& bytes, ErrorCode code, const std::string& named) {
  const auto mesh = decode(bytes);
  REQUIRE_FALSE(mesh.has_value());
  CAPTURE(mesh.error().detail);
  CHECK(mesh.error().code.name() == code.name());
  CHECK(mesh.error().detail.find(named) != std::string::npos);
}

// A triangle drawn in instances.
GltfFixture instanced(const json& attributes) {
  auto f = one_triangle();
  f.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
  f.document["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  return f;
}

std::size_t vec3(GltfFixture& f, const std::vector<float>& values) {
  return f.accessor(f.view(bytes_of(values)), 5126, values.size() / 3, "VEC3");
}

}  // namespace

TEST_CASE("a view compressed by meshopt decodes to what it was made of") {
  const Grid g = grid(40);
  const auto mesh = decode(file_of(compressed_grid(g)));
  if (!mesh) FAIL(mesh.error().detail);
  const TriangleSoup plain = plain_soup(g);
  CHECK(mesh->soup.positions == plain.positions);
  // The codec turns a triangle's corners in a circle, and keeps the triangles' order.
  REQUIRE(mesh->soup.faces.size() == plain.faces.size());
  for (std::size_t i = 0; i < plain.faces.size(); ++i) {
    auto face = plain.faces[i];
    int turns = 0;
    for (; turns < 3 && face != mesh->soup.faces[i]; ++turns) {
      std::rotate(face.begin(), face.begin() + 1, face.end());
    }
    CHECK(turns < 3);
  }
}

TEST_CASE("an index sequence keeps corners in place, in two bytes as well as in four") {
  const Grid g = grid(9);
  for (const std::size_t stride : {2, 4}) {
    CAPTURE(stride);
    GltfFixture f;
    const auto position = f.positions(g.xyz);
    const auto view = compressed_view(f, encoded_sequence(g.corners, 81), g.corners.size(), stride,
                                      "INDICES", "KHR_meshopt_compression");
    f.mesh({GltfFixture::primitive(
        position, 4, f.accessor(view, stride == 2 ? 5123 : 5125, g.corners.size(), "SCALAR"))});
    f.node({{"mesh", 0}});
    const auto mesh = decode(file_of(f));
    if (!mesh) FAIL(mesh.error().detail);
    CHECK(mesh->soup.faces == plain_soup(g).faces);
  }
}

TEST_CASE("the exponential filter gives back floats to the bits that were kept") {
  const Grid g = grid(12);
  const std::size_t count = g.xyz.size() / 3;
  std::vector<std::uint32_t> filtered(g.xyz.size());
#if MESHOPTIMIZER_VERSION >= 200  // asks which numbers share an exponent: those of a vector
  meshopt_encodeFilterExp(filtered.data(), count, 12, 20, g.xyz.data(),
                          meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(filtered.data(), count, 12, 20, g.xyz.data());
#endif
  auto f = compressed_grid(g);
  const auto view =
      compressed_view(f, encoded_vertices(bytes_of(filtered), count, 12), count, 12, "ATTRIBUTES");
  meshopt_of(f, view)["filter"] = "EXPONENTIAL";
  f.document["accessors"][0]["bufferView"] = view;
  const auto mesh = decode(file_of(f));
  if (!mesh) FAIL(mesh.error().detail);
  check_close(mesh->soup.positions, plain_soup(g).positions, 12 * std::ldexp(1.0, -19));
}

TEST_CASE("compressed data of a codec that is not known falls back to plain bytes, if any") {
  const Grid g = grid(5);
  auto f = compressed_grid(g);
  // The next version of the codec: the high half of the first byte tells the codec.
  f.binary[0] = std::byte{0xAF};
  check_refuses(file_of(f), InputCode::extension_required, "bufferView 0");
  const auto fallback = f.view(bytes_of(g.xyz));
  f.document["bufferViews"][0]["buffer"] = 0;
  f.document["bufferViews"][0]["byteOffset"] = f.document["bufferViews"][fallback]["byteOffset"];
  const auto mesh = decode(file_of(f));
  if (!mesh) FAIL(mesh.error().detail);
  CHECK(mesh->soup.positions == plain_soup(g).positions);
}

TEST_CASE("compressed views that lie are refused, naming the view") {
  const auto spoilt = [](const char* key, const json& value) {
    auto f = compressed_grid(grid(5));
    meshopt_of(f, 0)[key] = value;
    return file_of(f);
  };
  check_refuses(spoilt("mode", "TRIANGLE"), malformed, "bufferView 0");
  check_refuses(spoilt("filter", 7), malformed, "bufferView 0");
  check_refuses(spoilt("filter", "QUATERNION"), malformed, "bufferView 0: its compressed data");
  check_refuses(spoilt("byteStride", 10), malformed, "bufferView 0: its compressed data claims");
  check_refuses(spoilt("byteStride", 300), malformed, "bufferView 0: `byteStride`");
  check_refuses(spoilt("byteLength", 1'000'000), malformed,
                "bufferView 0: its compressed data reaches");
  check_refuses(spoilt("byteOffset", 9007199254740992), malformed, "bufferView 0: its compressed");
  check_refuses(spoilt("buffer", 2), malformed, "bufferView 0");
  check_refuses(spoilt("count", 24), malformed, "bufferView 0");
  check_refuses(spoilt("byteLength", 20), malformed, "bufferView 0: its compressed data");
}

TEST_CASE("a compressed view that claims gigabytes is refused before memory is taken") {
  auto f = compressed_grid(grid(5));
  meshopt_of(f, 0)["count"] = 1'000'000'000;
  f.document["bufferViews"][0]["byteLength"] = 12'000'000'000;
  check_refuses(file_of(f), malformed, "bufferView 0 claims 1000000000 elements");
  // All views together are bounded too.
  auto many = compressed_grid(grid(40));
  DecodeLimits limits;
  limits.max_vertices = 1604;
  limits.max_faces = 3042;
  CHECK(decode_mesh(file_of(many), limits).has_value());
  const json primitive = many.document["meshes"][0]["primitives"][0];
  for (int i = 0; i < 4; ++i) {
    many.document["bufferViews"].push_back(many.document["bufferViews"][0]);
    many.document["accessors"].push_back(
        {{"bufferView", 2 + i}, {"componentType", 5126}, {"count", 1}, {"type", "VEC3"}});
    many.document["meshes"][0]["primitives"].insert(
        many.document["meshes"][0]["primitives"].begin(), GltfFixture::primitive(2 + i, 0));
  }
  const auto refused = decode_mesh(file_of(many), limits);
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().code == ErrorCode::too_large);
}

TEST_CASE(
    "an instance is scaled, rotated and translated, and then its node's transform "
    "follows") {
  auto f = instanced(json::object());
  const auto half = static_cast<float>(std::numbers::sqrt2 / 2);
  const auto translation = vec3(f, {0, 0, 0, 10, 0, 0});
  const auto rotation = f.accessor(
      f.view(bytes_of(std::vector<float>{0, 0, 0, 1, 0, 0, half, half})), 5126, 2, "VEC4");
  const auto scale = vec3(f, {1, 1, 1, 2, 3, 1});
  f.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", translation}, {"ROTATION", rotation}, {"SCALE", scale}, {"_ID", 0}};
  f.document["nodes"][0]["translation"] = {0, 0, 5};
  const auto mesh = decoded(f);
  // The second: x by 2 and then to y, y by 3 and then to -x.
  check_close(mesh.soup.positions,
              {{0, 0, 5}, {1, 0, 5}, {0, 1, 5}, {10, 0, 5}, {10, 2, 5}, {7, 0, 5}}, 1e-6);
  REQUIRE(mesh.parts.size() == 2);
  CHECK(mesh.parts[1].node == 0);
  CHECK(mesh.parts[1].first_vertex == 3);
  CHECK(mesh.parts[1].first_face == 1);
}

TEST_CASE("rotations in bytes are made unit length again") {
  auto f = instanced(json::object());
  // 90 / 127 is not quite the root of a half.
  const auto rotation =
      f.accessor(f.view(bytes_of(std::vector<std::int8_t>{0, 0, 90, 90})), 5120, 1, "VEC4");
  f.document["accessors"][rotation]["normalized"] = true;
  f.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"ROTATION", rotation}};
  check_close(decoded(f).soup.positions, {{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}});
}

TEST_CASE("instances follow one another, each with all primitives, children after them") {
  GltfFixture f;
  const auto a = f.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const auto b = f.positions({0, 0, 1, 1, 0, 1, 0, 1, 1});
  f.mesh({GltfFixture::primitive(a), GltfFixture::primitive(b)});
  f.mesh({GltfFixture::primitive(a)});
  const auto translation = vec3(f, {0, 0, 0, 100, 0, 0});
  f.node({{"mesh", 0},
          {"children", {1}},
          {"extensions",
           {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", translation}}}}}}}});
  f.node({{"mesh", 1}});
  const auto mesh = decoded(f);
  std::vector<std::pair<std::int64_t, std::int64_t>> order;
  for (const MeshPart& part : mesh.parts) order.emplace_back(part.node, part.primitive);
  CHECK(order ==
        std::vector<std::pair<std::int64_t, std::int64_t>>{{0, 0}, {0, 1}, {0, 0}, {0, 1}, {1, 0}});
  CHECK(mesh.soup.positions[6] == Vec3{100, 0, 0});
  CHECK(mesh.soup.positions[12] == Vec3{0, 0, 0});  // instances are not inherited
}

TEST_CASE("instances are counted before memory is taken") {
  auto f = instanced(json::object());
  // A sparse accessor without bytes of its own, as long as the file.
  const auto translation =
      f.add("accessors", {{"componentType", 5126},
                          {"count", 500},
                          {"type", "VEC3"},
                          {"sparse",
                           {{"count", 1},
                            {"indices", {{"bufferView", 1}, {"componentType", 5123}}},
                            {"values", {{"bufferView", 0}}}}}});
  f.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", translation}};
  CHECK(decoded(f).soup.faces.size() == 500);
  DecodeLimits limits;
  limits.max_nodes = 500;  // and the node itself
  const auto nodes = decode_mesh(f.glb(), limits);
  REQUIRE_FALSE(nodes.has_value());
  CHECK(nodes.error().code == ErrorCode::too_large);
  CHECK(nodes.error().detail.find("node 0") != std::string::npos);
  limits.max_nodes = 1001;
  limits.max_vertices = 1499;
  const auto vertices = decode_mesh(f.glb(), limits);
  REQUIRE_FALSE(vertices.has_value());
  CHECK(vertices.error().code == ErrorCode::too_many_vertices);
  limits.max_vertices = 1500;
  CHECK(decode_mesh(f.glb(), limits).has_value());
}

TEST_CASE("instances with faults are refused, naming the node") {
  auto f = instanced({{"TRANSLATION", 9}});
  check_refuses(f.glb(), malformed, "node 0: `TRANSLATION`");
  f = instanced({{"ROTATION", 0}});
  check_refuses(f.glb(), malformed, "node 0, its instances: accessor 0 can't hold rotations");
  f = instanced({{"SCALE", 1}});
  check_refuses(f.glb(), malformed, "node 0, its instances: accessor 1 can't hold");
  f = instanced({{"TRANSLATION", 0}});
  f.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] =
      vec3(f, {1, 1, 1});
  check_refuses(f.glb(), malformed, "node 0: the accessors of its instances");
  f = instanced(7);
  check_refuses(f.glb(), malformed, "node 0: EXT_mesh_gpu_instancing has no `attributes`");
  f = instanced(json::object());
  f.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      vec3(f, {1, INFINITY, 1});
  check_refuses(f.glb(), malformed, "node 0: the transform of its instance 0");
}

TEST_CASE("morph targets move positions by the mesh's weights, or the node's instead") {
  auto f = one_triangle();
  const auto up = f.positions({0, 0, 1, 0, 0, 1, 0, 0, 1});
  const auto right = f.positions({0, 0, 0, 4, 0, 0, 0, 0, 0});
  f.document["meshes"][0]["primitives"][0]["targets"] = {
      {{"NORMAL", 0}}, {{"POSITION", up}}, {{"POSITION", right}}};
  // No weights: all are zero.
  CHECK(decoded(f).soup.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  f.document["meshes"][0]["weights"] = {1, 0.5, 0.25};
  f.document["nodes"][0]["scale"] = {1, 1, 10};
  const auto mesh = decoded(f);
  CHECK(mesh.soup.positions == std::vector<Vec3>{{0, 0, 5}, {2, 0, 5}, {0, 1, 5}});
  CHECK(warns_of(mesh, "mesh 0, primitive 0 has morph targets, which are taken at their default"));
  f.document["nodes"][0]["weights"] = {0, 0, -1};
  CHECK(decoded(f).soup.positions == std::vector<Vec3>{{0, 0, 0}, {-3, 0, 0}, {0, 1, 0}});
}

TEST_CASE("sparse morph targets move a few vertices alone") {
  auto f = one_triangle();
  const auto index = f.view(bytes_of(std::vector<std::uint16_t>{2}));
  const auto value = f.view(bytes_of(std::vector<float>{0, 0, 7}));
  const auto target =
      f.add("accessors", {{"componentType", 5126},
                          {"count", 3},
                          {"type", "VEC3"},
                          {"sparse",
                           {{"count", 1},
                            {"indices", {{"bufferView", index}, {"componentType", 5123}}},
                            {"values", {{"bufferView", value}}}}}});
  f.document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", target}}};
  f.document["meshes"][0]["weights"] = {1};
  CHECK(decoded(f).soup.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 7}});
}

// glTF 2.0, section 5.1.1: an accessor without a buffer view is zeros.
TEST_CASE("targets and instances whose accessors have no bytes are zeros") {
  const auto without_bytes = [](GltfFixture& f, std::uint64_t count, const char* type) {
    return f.add("accessors", {{"componentType", 5126}, {"count", count}, {"type", type}});
  };
  auto f = one_triangle();
  const auto nothing = without_bytes(f, 3, "VEC3");
  const auto up = f.positions({0, 0, 1, 0, 0, 1, 0, 0, 1});
  f.document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", nothing}},
                                                         {{"POSITION", up}}};
  f.document["meshes"][0]["weights"] = {1, 0.5};
  CHECK(decoded(f).soup.positions == std::vector<Vec3>{{0, 0, 0.5}, {1, 0, 0.5}, {0, 1, 0.5}});
  f.document["accessors"][nothing]["count"] = 4;
  check_refuses(f.glb(), malformed, "is a morph target of 4 positions");

  f = instanced(json::object());
  const auto here = without_bytes(f, 2, "VEC3");
  const auto scale = vec3(f, {1, 1, 1, 2, 2, 2});
  json& attributes = f.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes = {{"TRANSLATION", here}, {"SCALE", scale}};
  CHECK(decoded(f).soup.positions ==
        std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {2, 0, 0}, {0, 2, 0}});
  attributes["ROTATION"] = without_bytes(f, 2, "VEC4");
  CHECK(decoded(f).soup.faces.size() == 2);
  attributes = {{"TRANSLATION", without_bytes(f, 900'000, "VEC3")}};
  check_refuses(f.glb(), malformed, "claims 900000 elements without a bufferView");
}

TEST_CASE("morph targets with faults are refused, naming primitive and accessor") {
  const auto with = [](const std::vector<float>& target) {
    auto f = one_triangle();
    f.document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", f.positions(target)}}};
    f.document["meshes"][0]["weights"] = {1};
    return f;
  };
  check_refuses(with({0, 0, 0}).glb(), malformed,
                "mesh 0, primitive 0: accessor 2 is a morph target of 1 positions");
  check_refuses(with({0, 0, 0, 0, NAN, 0, 0, 0, 0}).glb(), malformed,
                "accessor 2: position 1 is not finite");
  auto f = with({0, 0, 0, 0, 0, 0, 0, 0, 0});
  f.document["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = 99;
  check_refuses(f.glb(), malformed, "mesh 0, primitive 0: `POSITION`");
  f.document["meshes"][0]["primitives"][0]["targets"] = 7;
  check_refuses(f.glb(), malformed, "mesh 0, primitive 0: `targets`");
}

TEST_CASE("morph targets that share one accessor can't multiply the work without end") {
  auto f = one_triangle();
  const json target = {{"POSITION", 0}};
  f.document["meshes"][0]["primitives"][0]["targets"] = std::vector<json>(100, target);
  f.document["meshes"][0]["weights"] = std::vector<double>(100, 0.5);
  DecodeLimits limits;
  limits.max_vertices = 18;
  const auto refused = decode_mesh(f.glb(), limits);
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().code == ErrorCode::too_large);
  limits.max_vertices = 19;
  CHECK(decode_mesh(f.glb(), limits).has_value());
}

TEST_CASE("morph targets that move nothing can't be gone through without end either") {
  auto f = one_triangle();
  f.document["meshes"][0]["primitives"][0]["targets"] = std::vector<json>(2000, json::object());
  f.document["meshes"][0]["weights"] = std::vector<double>(2000, 0.5);
  for (int i = 0; i < 9; ++i) f.node({{"mesh", 0}});
  DecodeLimits limits;
  limits.max_vertices = 20'000 / 16;
  CHECK(decode_mesh(f.glb(), limits).has_value());
  --limits.max_vertices;
  const auto refused = decode_mesh(f.glb(), limits);
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().code == ErrorCode::too_large);
  CHECK(refused.error().actual == std::uint64_t{20'000});
  // Those without a weight are not looked at.
  f.document["meshes"][0]["weights"] = {0.5};
  CHECK(decode_mesh(f.glb(), limits).has_value());
}

TEST_CASE("positions stay relative to the center of CESIUM_RTC, and that is said") {
  auto f = one_triangle();
  f.document["extensionsRequired"] = {"CESIUM_RTC"};
  f.document["extensions"]["CESIUM_RTC"]["center"] = {6378137, 0, 0};
  const auto mesh = decoded(f);
  CHECK(mesh.soup.positions[1] == Vec3{1, 0, 0});
  CHECK(warns_of(mesh, "CESIUM_RTC"));
}
