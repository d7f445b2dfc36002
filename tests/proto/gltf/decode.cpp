// What valid glTF files decode to: positions, faces and parts worked out by hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "proto/wire/input_codes.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

using Faces = std::vector<std::array<std::uint32_t, 3>>;
using Points = std::vector<Vec3>;

// Five vertices that make three faces as a strip, as a fan, and with indices.
const std::vector<float> five = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0};

GltfFixture drawn(int mode) {
  GltfFixture f;
  f.mesh({GltfFixture::primitive(f.positions(five), mode)});
  f.node({{"mesh", 0}});
  return f;
}

}  // namespace

TEST_CASE("a triangle list without indices takes its vertices in threes") {
  GltfFixture f;
  f.mesh({GltfFixture::primitive(
      f.positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1}))});
  f.node({{"mesh", 0}});
  CHECK(decoded(f).soup.faces == Faces{{0, 1, 2}, {3, 4, 5}});
}

TEST_CASE("corners that make up no whole triangle are left out with a warning") {
  const auto mesh = decoded(drawn(4));
  CHECK(mesh.soup.faces == Faces{{0, 1, 2}});
  CHECK(mesh.soup.positions.size() == 5);
  CHECK(warns_of(mesh, "no whole triangle"));
}

TEST_CASE("strips alternate their winding and fans turn about the first vertex") {
  CHECK(decoded(drawn(5)).soup.faces == Faces{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}});
  CHECK(decoded(drawn(6)).soup.faces == Faces{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}});
}

TEST_CASE("every face of an expanded strip looks the same way") {
  const auto soup = decoded(drawn(5)).soup;
  for (const auto& [a, b, c] : soup.faces) {
    const Vec3 normal =
        cross(soup.positions[b] - soup.positions[a], soup.positions[c] - soup.positions[a]);
    CHECK(normal.z < 0);
  }
}

TEST_CASE("degenerate faces of an indexed strip keep their numbers") {
  GltfFixture f;
  const auto position = f.positions(five);
  f.mesh({GltfFixture::primitive(position, 5, f.indices({0, 1, 2, 2, 3, 4}))});
  f.node({{"mesh", 0}});
  CHECK(decoded(f).soup.faces == Faces{{0, 1, 2}, {1, 2, 2}, {2, 2, 3}, {2, 4, 3}});
}

TEST_CASE("indices may have 8, 16 or 32 bits") {
  for (const int type : {5121, 5123, 5125}) {
    CAPTURE(type);
    GltfFixture f;
    const auto position = f.positions(five);
    const auto bytes = type == 5121   ? bytes_of(std::vector<std::uint8_t>{4, 3, 2})
                       : type == 5123 ? bytes_of(std::vector<std::uint16_t>{4, 3, 2})
                                      : bytes_of(std::vector<std::uint32_t>{4, 3, 2});
    f.mesh({GltfFixture::primitive(position, 4, f.accessor(f.view(bytes), type, 3, "SCALAR"))});
    f.node({{"mesh", 0}});
    CHECK(decoded(f).soup.faces == Faces{{4, 3, 2}});
  }
}

TEST_CASE("interleaved positions are found by stride and offset") {
  GltfFixture f;
  // normal, position, by turns
  const std::vector<float> both = {9, 9, 9, 0, 0, 0, 9, 9, 9, 1, 0, 0, 9, 9, 9, 0, 1, 0};
  const auto position = f.accessor(f.view(bytes_of(both), 24), 5126, 3, "VEC3");
  f.document["accessors"][position]["byteOffset"] = 12;
  f.mesh({GltfFixture::primitive(position)});
  f.node({{"mesh", 0}});
  CHECK(decoded(f).soup.positions == Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
}

TEST_CASE("sparse elements replace those of the base, or zeros where there is none") {
  for (const bool has_base : {true, false}) {
    CAPTURE(has_base);
    auto f = one_triangle();
    const auto indices = f.view(bytes_of(std::vector<std::uint8_t>{0, 2}));
    const auto values = f.view(bytes_of(std::vector<float>{5, 5, 5, 7, 7, 7}));
    f.document["accessors"][0]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
        {"values", {{"bufferView", values}}}};
    if (!has_base) f.document["accessors"][0].erase("bufferView");
    const Vec3 kept = has_base ? Vec3{1, 0, 0} : Vec3{0, 0, 0};
    CHECK(decoded(f).soup.positions == Points{{5, 5, 5}, kept, {7, 7, 7}});
  }
}

TEST_CASE("quantised positions are plain integers, or fractions when normalised") {
  const auto with = [](int type, const Bytes& bytes, bool normalized) {
    GltfFixture f;
    const std::size_t size = bytes.size() / 3;
    const auto position = f.accessor(f.view(bytes, size), type, 3, "VEC3");
    f.document["accessors"][position]["normalized"] = normalized;
    f.document["extensionsRequired"] = {"KHR_mesh_quantization"};
    f.mesh({GltfFixture::primitive(position)});
    f.node({{"mesh", 0}});
    return decoded(f).soup.positions;
  };
  // Three components and one of padding.
  const auto i8 = bytes_of(std::vector<std::int8_t>{-128, 0, 0, 99, 127, 0, 0, 99, 0, -127, 0, 99});
  check_close(with(5120, i8, false), {{-128, 0, 0}, {127, 0, 0}, {0, -127, 0}});
  check_close(with(5120, i8, true), {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}});
  const auto u8 = bytes_of(std::vector<std::uint8_t>{255, 0, 0, 99, 51, 0, 0, 99, 0, 102, 0, 99});
  check_close(with(5121, u8, false), {{255, 0, 0}, {51, 0, 0}, {0, 102, 0}});
  check_close(with(5121, u8, true), {{1, 0, 0}, {0.2, 0, 0}, {0, 0.4, 0}});
  const auto i16 =
      bytes_of(std::vector<std::int16_t>{-32768, 0, 0, 9, 32767, 0, 0, 9, 0, -32767, 0, 9});
  check_close(with(5122, i16, false), {{-32768, 0, 0}, {32767, 0, 0}, {0, -32767, 0}});
  check_close(with(5122, i16, true), {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}});
  const auto u16 =
      bytes_of(std::vector<std::uint16_t>{65535, 0, 0, 9, 13107, 0, 0, 9, 0, 26214, 0, 9});
  check_close(with(5123, u16, false), {{65535, 0, 0}, {13107, 0, 0}, {0, 26214, 0}});
  check_close(with(5123, u16, true), {{1, 0, 0}, {0.2, 0, 0}, {0, 0.4, 0}});
}

TEST_CASE("a node scales, then rotates, then translates, and its parent follows") {
  auto f = one_triangle();
  f.document["nodes"] = json::array();
  const double half = std::sqrt(0.5);  // a quarter turn about z: x goes to y
  f.node({{"mesh", 0},
          {"scale", {2, 3, 1}},
          {"rotation", {0, 0, half, half}},
          {"translation", {10, 0, 0}}});
  // column-major: z up by 5, everything doubled
  f.node({{"children", {0}}, {"matrix", {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 5, 1}}});
  // (0,0,0) -> (10,0,0) -> (20,0,5); (1,0,0) -> (2,0,0) -> (0,2,0) -> (10,2,0) -> (20,4,5);
  // (0,1,0) -> (0,3,0) -> (-3,0,0) -> (7,0,0) -> (14,0,5)
  check_close(decoded(f).soup.positions, {{20, 0, 5}, {20, 4, 5}, {14, 0, 5}});
}

TEST_CASE("a mirroring scale moves vertices and leaves the corners of faces in order") {
  auto f = one_triangle();
  f.document["nodes"][0]["scale"] = {-1, 1, 1};
  const auto mesh = decoded(f);
  check_close(mesh.soup.positions, {{0, 0, 0}, {-1, 0, 0}, {0, 1, 0}});
  CHECK(mesh.soup.faces == Faces{{0, 1, 2}});
}

TEST_CASE("vertices follow nodes depth first, then primitives, instance by instance") {
  GltfFixture f;
  const auto a = f.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const auto b = f.positions({0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1});
  f.mesh({GltfFixture::primitive(a), GltfFixture::primitive(b, 5)});
  f.mesh({GltfFixture::primitive(a)});
  f.document["meshes"][0]["name"] = "pair";
  f.node({{"children", {2, 1}}, {"name", "root"}});
  f.node({{"mesh", 1}, {"name", "late"}});
  f.node({{"mesh", 1}, {"translation", {10, 0, 0}}, {"children", {3}}});
  f.node({{"mesh", 0}, {"translation", {0, 0, 5}}});
  f.document["scenes"] = {{{"nodes", json::array()}}, {{"nodes", {0}}}};
  f.document["scene"] = 1;
  const auto mesh = decoded(f);
  REQUIRE(mesh.parts.size() == 4);
  const auto is = [&](std::size_t i, int node, int m, int primitive, const char* name, int v,
                      int vs, int t, int ts) {
    CAPTURE(i);
    const MeshPart& part = mesh.parts[i];
    CHECK(part.node == node);
    CHECK(part.mesh == m);
    CHECK(part.primitive == primitive);
    CHECK(part.name == name);
    CHECK(static_cast<int>(part.first_vertex) == v);
    CHECK(static_cast<int>(part.vertex_count) == vs);
    CHECK(static_cast<int>(part.first_face) == t);
    CHECK(static_cast<int>(part.face_count) == ts);
  };
  is(0, 2, 1, 0, "", 0, 3, 0, 1);
  is(1, 3, 0, 0, "pair", 3, 3, 1, 1);
  is(2, 3, 0, 1, "pair", 6, 4, 2, 2);
  is(3, 1, 1, 0, "late", 10, 3, 4, 1);
  CHECK(mesh.soup.faces == Faces{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {7, 9, 8}, {10, 11, 12}});
  check_close({mesh.soup.positions[1], mesh.soup.positions[4], mesh.soup.positions[11]},
              {{11, 0, 0}, {11, 0, 5}, {1, 0, 0}});
}

TEST_CASE("without a default scene the first is drawn, and without scenes every root") {
  auto f = one_triangle();
  f.node({{"mesh", 0}});
  f.node({{"children", {1}}});
  CHECK(decoded(f).parts.size() == 2);
  f.document["scenes"] = {{{"nodes", {0}}}, {{"nodes", {0, 2}}}};
  CHECK(decoded(f).parts.size() == 1);
}

TEST_CASE("vertices of points and lines count, but make no part") {
  GltfFixture f;
  const auto position = f.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  f.mesh({GltfFixture::primitive(position, 1), GltfFixture::primitive(position)});
  f.node({{"mesh", 0}});
  const auto mesh = decoded(f);
  CHECK(mesh.soup.positions.size() == 6);
  CHECK(mesh.soup.faces == Faces{{3, 4, 5}});
  REQUIRE(mesh.parts.size() == 1);
  CHECK(mesh.parts[0].primitive == 1);
  CHECK(mesh.parts[0].first_vertex == 3);
  CHECK(warns_of(mesh, "mesh 0, primitive 0 draws points or lines"));
}

TEST_CASE("a skinned mesh is where the file has it, moved by its node, and that is said") {
  auto f = one_triangle();
  f.document["nodes"][0]["skin"] = 0;
  f.document["nodes"][0]["translation"] = {1, 2, 3};
  const auto mesh = decoded(f);
  CHECK(mesh.soup.positions == Points{{1, 2, 3}, {2, 2, 3}, {1, 3, 3}});
  REQUIRE(mesh.findings.size() == 1);
  CHECK(mesh.findings[0].code == "skin_at_bind_pose");
  CHECK(warns_of(mesh, "node 0 has a skin"));
}

TEST_CASE("extensions that leave geometry alone may be required") {
  auto f = one_triangle();
  f.document["extensionsRequired"] = {"KHR_texture_transform", "KHR_materials_unlit"};
  CHECK(decoded(f).soup.faces.size() == 1);
}

TEST_CASE("external images and broken materials do not matter") {
  auto f = one_triangle();
  f.document["images"] = {{{"uri", "../../secret.png"}}, {{"bufferView", 99}}, 17};
  f.document["materials"] = "none";
  f.document["extras"] = {{"a", {1, 2, "x"}}};
  CHECK(decoded(f).soup.faces.size() == 1);
}

TEST_CASE("a part's name is the node's, cut between code points") {
  auto f = one_triangle();
  std::string name = "x";
  for (int i = 0; i < 100; ++i) name += "\u00e9";  // two bytes each
  f.document["nodes"][0]["name"] = name;
  const auto mesh = decoded(f);
  CHECK(mesh.parts[0].name == name.substr(0, 197) + "\u2026");
}

TEST_CASE("a byte order mark, numbers such as 3.0 and trailing bytes are put up with") {
  auto f = one_triangle();
  f.document["accessors"][1]["count"] = 3.0;
  auto text = bytes_of("\xEF\xBB\xBF\n");
  const auto rest = f.gltf();
  text.insert(text.end(), rest.begin(), rest.end());
  CHECK(decode(text).has_value());
  auto glb = f.glb();
  glb.resize(glb.size() + 5);
  const auto mesh = decode(glb);
  REQUIRE(mesh.has_value());
  CHECK(warns_of(*mesh, "5 bytes after the end"));
}

TEST_CASE("the format is found from the bytes") {
  CHECK(sniff_format(one_triangle().glb()) == MeshFormat::glb);
  CHECK(sniff_format(one_triangle().gltf()) == MeshFormat::gltf);
  CHECK(sniff_format(bytes_of("DRACO")) == MeshFormat::drc);
  for (const char* other :
       {"", "glT", "plyers\n", "[1]", "solid", "\x89PNG", "v", "# v 1 2 3", "vase 1"}) {
    const auto format = sniff_format(bytes_of(other));
    REQUIRE_FALSE(format.has_value());
    CHECK(format.error().code == InputCode::format_unknown);
  }
}
