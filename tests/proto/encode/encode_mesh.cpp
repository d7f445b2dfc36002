// Encoding, and that decoding gives back what was encoded.
#include "proto/encode/encode_mesh.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <string>
#include <tuple>

#include "proto/encode/glb_drawing.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

// A bumpy open patch of n by n vertices, exact in float32.
TriangleSoup patch(std::uint32_t n) {
  TriangleSoup soup;
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      soup.positions.push_back({0.5 * x, 0.25 * y, 0.125 * ((x * x + 3 * y) % 7)});
    }
  }
  for (std::uint32_t y = 0; y + 1 < n; ++y) {
    for (std::uint32_t x = 0; x + 1 < n; ++x) {
      const std::uint32_t v = y * n + x;
      soup.faces.push_back({v, v + 1, v + n});
      soup.faces.push_back({v + 1, v + n + 1, v + n});
    }
  }
  return soup;
}

// Faces by their corners' positions, the least corner first: what is left of a
// mesh when the numbering of its vertices and faces is forgotten.
auto shape_of(const TriangleSoup& soup) {
  using Corner = std::tuple<double, double, double>;
  std::multiset<std::array<Corner, 3>> faces;
  for (const auto& face : soup.faces) {
    std::array<Corner, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& p = soup.positions[face[i]];
      corners[i] = {p.x, p.y, p.z};
    }
    std::rotate(corners.begin(), std::ranges::min_element(corners), corners.end());
    faces.insert(corners);
  }
  return faces;
}

}  // namespace

TEST_CASE("a GLB gives back the positions and faces it was made of") {
  const TriangleSoup soup = patch(20);
  const auto mesh = decode(encode_glb(soup, "patch"));
  REQUIRE(mesh.has_value());
  CHECK(mesh->soup.positions == soup.positions);
  CHECK(mesh->soup.faces == soup.faces);
  CHECK(mesh->findings.empty());
  REQUIRE(mesh->parts.size() == 1);
  CHECK(mesh->parts[0].name == "patch");
  CHECK(mesh->parts[0].vertex_count == 400);
}

TEST_CASE("an encoded GLB states the bounds of its positions and aligns its chunks") {
  const auto glb = encode_glb(patch(3), "three");
  CHECK(glb.size() % 4 == 0);
  const std::string text(reinterpret_cast<const char*>(glb.data()), glb.size());
  const auto end = text.find("BIN") - 4;
  const json document = json::parse(text.substr(20, end - 20));
  CHECK(document["accessors"][0]["min"] == json::array({0.0, 0.0, 0.0}));
  CHECK(document["accessors"][0]["max"] == json::array({1.0, 0.5, 0.75}));
  CHECK(document["accessors"][1]["count"] == 24);
  CHECK(document["buffers"][0]["byteLength"] == 9 * 12 + 8 * 12);
}

TEST_CASE("a coloured surface and a line are parts of one GLB") {
  const TriangleSoup soup = patch(3);
  std::vector<proto::GlbPart> parts(2);
  parts[0].name = "field";
  parts[0].positions = soup.positions;
  for (const auto& face : soup.faces) {
    parts[0].indices.insert(parts[0].indices.end(), face.begin(), face.end());
  }
  parts[0].colours.assign(9, proto::Colour{255, 0, 188});
  parts[1].name = "path";
  parts[1].mode = proto::GlbPart::Mode::line_strip;
  parts[1].positions = {{0, 0, 0}, {1, 2, 3}};
  const auto glb = proto::encode_glb_parts(parts);
  const auto mesh = decode(glb);
  REQUIRE(mesh.has_value());
  CHECK(mesh->soup.positions.size() == 11);  // a line's vertices count, but make no faces
  CHECK(mesh->soup.faces == soup.faces);
  REQUIRE(mesh->parts.size() == 1);
  CHECK(mesh->parts[0].name == "field");

  const std::string text(reinterpret_cast<const char*>(glb.data()), glb.size());
  const auto end = text.find("BIN") - 4;
  const json document = json::parse(text.substr(20, end - 20));
  const json& surface = document["meshes"][0]["primitives"][0];
  const json& line = document["meshes"][1]["primitives"][0];
  CHECK(surface["mode"] == 4);
  CHECK(line["mode"] == 3);
  CHECK_FALSE(line.contains("indices"));
  const json& material = document["materials"][line["material"].get<std::size_t>()];
  CHECK(material["extensions"].contains("KHR_materials_unlit"));
  const json& colours = document["accessors"][surface["attributes"]["COLOR_0"].get<std::size_t>()];
  CHECK(colours["count"] == 9);
  CHECK(colours["normalized"] == true);
  const json& view = document["bufferViews"][colours["bufferView"].get<std::size_t>()];
  const std::size_t first = end + 8 + view["byteOffset"].get<std::size_t>();
  // sRGB 188 is half as bright as white.
  CHECK(text.substr(first, 4) == std::string("\xFF\x00\x80\xFF", 4));
}

TEST_CASE("a GLB of nothing is a valid file without triangles") {
  const auto mesh = decode(encode_glb({}, "nothing"));
  REQUIRE_FALSE(mesh.has_value());
  CHECK(mesh.error().code == ErrorCode::no_triangles);
}

TEST_CASE("a name that is not UTF-8 is written with replacement characters") {
  const auto mesh = decode(encode_glb(patch(2), "a\xFF"));
  REQUIRE(mesh.has_value());
  CHECK(mesh->parts[0].name == "a\xEF\xBF\xBD");
}

TEST_CASE("Draco without quantisation gives back every face exactly, in another order") {
  const TriangleSoup soup = patch(20);
  const auto drc = encode_drc(soup, 0);
  REQUIRE(drc.has_value());
  const auto mesh = decode(*drc);
  REQUIRE(mesh.has_value());
  CHECK(mesh->format == MeshFormat::drc);
  CHECK(mesh->soup.positions.size() == soup.positions.size());
  CHECK(shape_of(mesh->soup) == shape_of(soup));
  REQUIRE(mesh->parts.size() == 1);
  CHECK(mesh->parts[0].node == -1);
  CHECK(mesh->parts[0].face_count == soup.faces.size());
}

TEST_CASE("quantised Draco is smaller and near") {
  const TriangleSoup soup = patch(20);
  const auto exact = encode_drc(soup, 0);
  const auto coarse = encode_drc(soup, 12);
  REQUIRE(exact.has_value());
  REQUIRE(coarse.has_value());
  CHECK(coarse->size() < exact->size());
  const auto mesh = decode(*coarse);
  REQUIRE(mesh.has_value());
  for (const Vec3& p : mesh->soup.positions) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& q : soup.positions) nearest = std::min(nearest, distance(p, q));
    CHECK(nearest < 9.5 / 4095);  // the box's longest side over 2^12 - 1
  }
}

TEST_CASE("what Draco can't store is refused") {
  TriangleSoup soup = patch(3);
  CHECK(encode_drc(soup, -1).error().code == ErrorCode::value_out_of_range);
  CHECK(encode_drc(soup, 31).error().code == ErrorCode::value_out_of_range);
  soup.faces.push_back({0, 1, 9});
  CHECK(encode_drc(soup, 0).error().code == ErrorCode::index_out_of_range);
  CHECK(encode_drc({}, 0).error().code == ErrorCode::no_triangles);
}

TEST_CASE("a primitive compressed by Draco is decoded, transformed and drawn twice") {
  const TriangleSoup soup = patch(5);
  const auto drc = encode_drc(soup, 0);
  REQUIRE(drc.has_value());
  GltfFixture f;
  f.document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  const auto view = f.view(*drc);
  f.add("accessors", {{"componentType", 5126}, {"count", 25}, {"type", "VEC3"}});
  f.add("accessors", {{"componentType", 5125}, {"count", 96}, {"type", "SCALAR"}});
  json primitive = GltfFixture::primitive(0, 4, 1);
  primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view},
                                                           {"attributes", {{"POSITION", 0}}}};
  f.mesh({primitive});
  f.node({{"mesh", 0}});
  f.node({{"mesh", 0}, {"translation", {0, 0, 8}}});
  const auto mesh = decode(f.glb());
  if (!mesh) FAIL(mesh.error().detail);
  const auto alone = decode(*drc);
  REQUIRE(alone.has_value());
  REQUIRE(mesh->soup.positions.size() == 50);
  REQUIRE(mesh->soup.faces.size() == 64);
  for (std::size_t i = 0; i < 25; ++i) {
    CHECK(mesh->soup.positions[i] == alone->soup.positions[i]);
    CHECK(mesh->soup.positions[25 + i] == alone->soup.positions[i] + Vec3{0, 0, 8});
  }
  CHECK(mesh->soup.faces[32][0] == alone->soup.faces[0][0] + 25);
  CHECK(mesh->findings.empty());

  f.document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]
            ["POSITION"] = 7;
  const auto other = decode(f.glb());
  REQUIRE_FALSE(other.has_value());
  CHECK(other.error().detail.find("no attribute of the id") != std::string::npos);
}

TEST_CASE("Draco drops degenerate faces and vertices without a face") {
  TriangleSoup soup = patch(3);
  const auto shape = shape_of(soup);
  soup.positions.push_back({9, 9, 9});
  soup.faces.push_back({0, 1, 1});
  const auto mesh = decode(encode_drc(soup, 0).value());
  REQUIRE(mesh.has_value());
  CHECK(mesh->soup.positions.size() == 9);
  CHECK(shape_of(mesh->soup) == shape);
}
