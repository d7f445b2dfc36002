// Which material each face has, as glTF and OBJ files say it.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "proto/encode/encode_mesh.h"
#include "proto/mesh/face_materials.h"
#include "tests/fixtures/test_seed.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

// By face.
std::vector<std::uint32_t> by_face(const DecodedMesh& mesh) {
  std::vector<std::uint32_t> materials;
  for (const MaterialRun& run : mesh.materials.runs) {
    CHECK(run.end > materials.size());
    CHECK((materials.empty() || materials.back() != run.material));
    materials.resize(run.end, run.material);
  }
  REQUIRE(materials.size() <= mesh.soup.faces.size());
  materials.resize(mesh.soup.faces.size(), kNoMaterial);
  return materials;
}

bool has_finding(const DecodedMesh& mesh, const std::string& code, std::uint64_t count) {
  return std::ranges::any_of(mesh.findings, [&](const Finding& finding) {
    return finding.code == code && finding.count == count;
  });
}

json draco_primitive(GltfFixture& f) {
  const auto drc = encode_drc({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}, 0);
  REQUIRE(drc);
  const std::size_t position =
      f.add("accessors", {{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  const std::size_t indices =
      f.add("accessors", {{"componentType", 5123}, {"count", 3}, {"type", "SCALAR"}});
  json primitive = GltfFixture::primitive(position, 4, indices);
  primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", f.view(*drc)},
                                                           {"attributes", {{"POSITION", 0}}}};
  f.document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return primitive;
}

}  // namespace

TEST_CASE("a face has its primitive's material in every instance, whatever the primitive") {
  const std::uint32_t seed = fixtures::test_seed();
  std::mt19937 random(seed);
  for (int round = 0; round < 30; ++round) {
    CAPTURE(seed);
    CAPTURE(round);
    GltfFixture f;
    const std::uint32_t count = random() % 5;
    for (std::uint32_t i = 0; i < count; ++i) {
      f.document["materials"].push_back(
          random() % 4 == 0 ? json::object() : json{{"name", std::string(1, 'a' + random() % 3)}});
    }
    const std::size_t position = f.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    // Of each mesh the materials of its faces.
    std::vector<std::vector<std::uint32_t>> of_mesh;
    std::uint64_t missing = 0;
    for (std::uint32_t m = 1 + random() % 4; m > 0; --m) {
      std::vector<json> primitives;
      std::vector<std::uint32_t> materials;
      for (std::uint32_t p = 1 + random() % 4; p > 0; --p) {
        const bool is_line = random() % 5 == 0;
        json primitive = is_line             ? GltfFixture::primitive(position, 1)
                         : random() % 3 == 0 ? draco_primitive(f)
                                             : GltfFixture::primitive(position);
        const std::uint32_t drawn = random() % 7;
        std::uint32_t material = kNoMaterial;
        if (drawn < count) {
          material = drawn;
          primitive["material"] = material;
        } else if (drawn == 6) {
          primitive["material"] = random() % 2 == 0 ? json(count) : json("steel");
        }
        if (!is_line) materials.push_back(material);
        primitives.push_back(std::move(primitive));
      }
      f.mesh(primitives);
      of_mesh.push_back(std::move(materials));
    }
    std::vector<std::uint32_t> expected;
    for (std::uint32_t n = 1 + random() % 5; n > 0; --n) {
      const std::uint32_t m = random() % of_mesh.size();
      f.node({{"mesh", m}, {"translation", {random() % 9, 0, 0}}});
      expected.insert(expected.end(), of_mesh[m].begin(), of_mesh[m].end());
      for (const json& primitive : f.document["meshes"][m]["primitives"]) {
        const auto it = primitive.find("material");
        if (it != primitive.end() && primitive["mode"] != 1 &&
            !(it->is_number() && it->get<std::uint32_t>() < count)) {
          ++missing;
        }
      }
    }
    if (expected.empty()) continue;
    const DecodedMesh mesh = decoded(f);
    CHECK(by_face(mesh) == expected);
    REQUIRE(mesh.materials.names.size() == count);
    for (std::uint32_t i = 0; i < count; ++i) {
      CHECK(mesh.materials.names[i] == f.document["materials"][i].value("name", ""));
      CHECK(mesh.materials.face_counts()[i] ==
            static_cast<std::uint64_t>(std::ranges::count(expected, i)));
    }
    REQUIRE(mesh.parts.size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK(mesh.parts[i].material ==
            (expected[i] == kNoMaterial ? -1 : std::int64_t{expected[i]}));
    }
    CHECK(has_finding(mesh, "material_not_there", missing) == (missing > 0));
  }
}

TEST_CASE("materials that are nonsense are no reason to refuse a mesh") {
  for (const json& materials :
       {json("none"), json(json::object()), json::array({7, nullptr, json{{"name", 5}}})}) {
    auto f = one_triangle();
    f.document["materials"] = materials;
    f.document["meshes"][0]["primitives"][0]["material"] = 2;
    const DecodedMesh mesh = decoded(f);
    CHECK(mesh.materials.names.size() == (materials.is_array() ? 3 : 0));
    CHECK(by_face(mesh)[0] == (materials.is_array() ? 2 : kNoMaterial));
  }
  for (const json& material : {json(-1), json(1e300), json(4294967295), json(nullptr), json(1.5)}) {
    auto f = one_triangle();
    f.document["materials"] = {{{"name", "a"}}};
    f.document["meshes"][0]["primitives"][0]["material"] = material;
    const DecodedMesh mesh = decoded(f);
    CHECK(by_face(mesh)[0] == kNoMaterial);
    CHECK(has_finding(mesh, "material_not_there", 1));
  }
  auto f = one_triangle();
  f.document["materials"] = {{{"name", "a"}}, {{"name", std::string(1000, 'n')}}};
  f.document["meshes"][0]["primitives"][0]["material"] = 1.0;
  const DecodedMesh mesh = decoded(f);
  CHECK(by_face(mesh)[0] == 1);
  CHECK(mesh.materials.names[1].size() <= kMostNameBytes);
}

TEST_CASE("of very many materials the first ones are kept, and faces know that they have others") {
  GltfFixture f;
  const std::size_t position = f.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const std::size_t count = kMostMaterials + 5;
  std::vector<json> primitives;
  std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (std::size_t i = 0; i < count; ++i) {
    f.document["materials"].push_back({{"name", std::to_string(i)}});
    primitives.push_back(GltfFixture::primitive(position));
    primitives.back()["material"] = i;
    obj += "usemtl " + std::to_string(i) + "\nf 1 2 3\n";
  }
  f.mesh(primitives);
  f.node({{"mesh", 0}});
  const auto of_obj = decode(bytes_of(obj));
  REQUIRE(of_obj);
  for (const DecodedMesh& mesh : {decoded(f), *of_obj}) {
    CHECK(mesh.materials.names.size() == kMostMaterials);
    CHECK(mesh.materials.names.back() == std::to_string(kMostMaterials - 1));
    CHECK(mesh.materials.faces_beyond(kMostMaterials) == 5);
    CHECK(mesh.materials.faces_beyond(0) == count);
    CHECK(by_face(mesh)[kMostMaterials - 1] == kMostMaterials - 1);
    CHECK(by_face(mesh)[count - 1] >= kMostMaterials);
    CHECK(by_face(mesh)[count - 1] != kNoMaterial);
  }
}

TEST_CASE("OBJ faces have the material named last, polygons all their triangles") {
  const std::uint32_t seed = fixtures::test_seed();
  std::mt19937 random(seed);
  const std::vector<std::string> kNames{"glass", "Dark Glass", "3", "\xff\xfe", "none"};
  for (int round = 0; round < 30; ++round) {
    CAPTURE(seed);
    CAPTURE(round);
    std::string text = "mtllib a.mtl\n";
    for (int i = 0; i < 8; ++i) {
      const double angle = 0.78 * i;
      text +=
          "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0\n";
    }
    std::vector<std::string> order;
    std::vector<std::uint32_t> expected;
    std::uint32_t present = kNoMaterial;
    for (std::uint32_t line = 1 + random() % 20; line > 0; --line) {
      if (random() % 2 == 0) {
        const std::size_t drawn = random() % (kNames.size() + 1);
        const std::string name = drawn < kNames.size() ? kNames[drawn] : "";
        text += "usemtl \t" + name + (random() % 2 == 0 ? "  \r\n" : "\n");
        const auto known = std::find(order.begin(), order.end(), name);
        present = name.empty() ? kNoMaterial : static_cast<std::uint32_t>(known - order.begin());
        if (!name.empty() && known == order.end()) order.push_back(name);
      }
      const std::uint32_t corners = 3 + random() % 6;
      text += "f";
      for (std::uint32_t c = 1; c <= corners; ++c) text += " " + std::to_string(c);
      text += "\n";
      expected.insert(expected.end(), corners - 2, present);
    }
    const auto mesh = decode(bytes_of(text));
    REQUIRE(mesh);
    CHECK(by_face(*mesh) == expected);
    REQUIRE(mesh->materials.names.size() == order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      CHECK(mesh->materials.names[i] == (order[i] == "\xff\xfe" ? "\ufffd\ufffd" : order[i]));
    }
    const bool is_one =
        std::ranges::count(expected, expected[0]) == static_cast<std::ptrdiff_t>(expected.size());
    CHECK(mesh->parts[0].material ==
          (is_one && expected[0] != kNoMaterial ? std::int64_t{expected[0]} : -1));
  }
}
