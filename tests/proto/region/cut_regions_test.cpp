// Which faces regions leave of a mesh, and shapes that a mesh does not have.
#include "proto/region/cut_regions.h"

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/mesh/mesh.h"
#include "core/mesh/shapes.h"
#include "core/mesh/triangle_soup.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/mesh/face_materials.h"
#include "proto/mesh/face_numbers.h"
#include "proto/region/file_faces.h"
#include "proto/region/region.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"
#include "tests/proto/region/asked_regions.h"

using namespace geodesic;
using namespace geodesic::proto;
using nlohmann::json;

namespace {

Mesh mesh_of(const TriangleSoup& soup) {
  auto mesh = Mesh::build(soup);
  REQUIRE(mesh);
  return std::move(*mesh);
}

// The source faces that are left.
std::vector<std::uint32_t> left_of(const Result<Mesh>& cut) {
  REQUIRE(cut);
  std::vector<std::uint32_t> left;
  for (std::uint32_t f = 0; f < cut->source_face_count(); ++f) {
    if (cut->face_of_source(f) != kNone) left.push_back(f);
  }
  return left;
}

}  // namespace

TEST_CASE("RegionsAreUnionsAndForbiddenIsTakenAwayFromWithin") {
  const std::uint32_t seed = fixtures::test_seed();
  std::mt19937 random(seed);
  const auto unit = [&] { return random() / 4294967296.0; };
  for (std::uint32_t round = 0; round < 40; ++round) {
    CAPTURE(seed + round);
    const fixtures::RandomMesh drawn(seed + round);
    const TriangleSoup& soup = drawn.soup();
    const Mesh mesh = mesh_of(soup);
    const auto faces = static_cast<std::uint32_t>(soup.faces.size());
    FileFaces file;
    file.parts.parts = {{0, faces / 3, "a"}, {faces / 3, 0, "b"}, {faces / 3, faces, "a"}};
    file.parts.total = 3;
    // By face: one of these, or none. Two have one name; faces behind the last run have none.
    FaceMaterials materials;
    for (const char* name : {"x", "y", "x", ""}) materials.add_name(name);
    std::vector<std::uint32_t> material_of;
    while (material_of.size() < faces && random() % 12 > 0) {
      const std::uint32_t drawn_place = random() % 6;
      const std::uint32_t place = drawn_place < 4 ? drawn_place : kNoMaterial;
      const std::uint32_t count = random() % 8;
      materials.add_faces(count, place);
      material_of.insert(material_of.end(), count, place);
    }
    material_of.resize(faces, kNoMaterial);
    file.materials = std::make_shared<const FaceMaterials>(materials);
    const auto labels = std::make_shared<FaceNumbers>();
    for (std::uint32_t f = 0; f < faces; ++f) labels->by_face.push_back(double(random() % 5));
    file.labels["_SEG"] = labels;
    const Vec3 size = mesh.box().max - mesh.box().min;
    const auto place = [&] {
      return mesh.box().min + Vec3{unit() * size.x, unit() * size.y, unit() * size.z};
    };
    // By its definition, one face at a time.
    const auto has = [&](const std::vector<Shape>& region, std::uint32_t f) {
      const auto& t = soup.faces[f];
      const Vec3 p =
          (1.0 / 3) * (soup.positions[t[0]] + soup.positions[t[1]] + soup.positions[t[2]]);
      for (const Shape& shape : region) {
        if (const auto* ranges = std::get_if<std::vector<FaceRange>>(&shape.what)) {
          for (const auto& [first, last] : *ranges) {
            if (first <= f && f <= last) return true;
          }
        } else if (const auto* part = std::get_if<PartShape>(&shape.what)) {
          const auto* name = std::get_if<std::string>(&part->part);
          for (std::size_t i = 0; i < 3; ++i) {
            const auto& [first, count, called] = file.parts.parts[i];
            if (name != nullptr ? called != *name : std::get<std::uint64_t>(part->part) != i) {
              continue;
            }
            if (first <= f && f < first + count) return true;
          }
        } else if (const auto* of = std::get_if<MaterialShape>(&shape.what)) {
          const std::uint32_t has = material_of[f];
          if (std::holds_alternative<NoMaterial>(of->material)) {
            if (has == kNoMaterial) return true;
          } else if (const auto* name = std::get_if<std::string>(&of->material)) {
            if (has != kNoMaterial && materials.names[has] == *name) return true;
          } else if (has == std::get<std::uint64_t>(of->material)) {
            return true;
          }
        } else if (const auto* label = std::get_if<LabelShape>(&shape.what)) {
          if (labels->by_face[f] == label->value) return true;
        } else if (const auto* ball = std::get_if<SphereShape>(&shape.what)) {
          if (norm(p - ball->center) <= ball->radius) return true;
        } else {
          const auto& box = std::get<BoxShape>(shape.what);
          if (p.x >= box.min.x && p.y >= box.min.y && p.z >= box.min.z && p.x <= box.max.x &&
              p.y <= box.max.y && p.z <= box.max.z) {
            return true;
          }
        }
      }
      return false;
    };
    const auto draw_region = [&] {
      std::vector<Shape> region;
      for (std::uint32_t i = random() % 4; i > 0; --i) {
        switch (random() % 9) {
          case 0: {
            std::vector<FaceRange> ranges;
            for (int k = 0; k < 3; ++k) {
              const std::uint64_t first = random() % faces;
              ranges.push_back({first, first + random() % (faces - first)});
            }
            region.push_back({std::move(ranges), "forbid"});
            break;
          }
          case 1:
            region.push_back({PartShape{random() % 3}, "forbid"});
            break;
          case 3:
            region.push_back({PartShape{random() % 2 == 0 ? "a" : "b"}, "forbid"});
            break;
          case 4:
            region.push_back({MaterialShape{random() % 4}, "forbid"});
            break;
          case 5: {
            const std::string name = random() % 3 == 0 ? "x" : random() % 2 == 0 ? "y" : "";
            region.push_back({MaterialShape{name}, "forbid"});
            break;
          }
          case 6:
            region.push_back({MaterialShape{NoMaterial{}}, "forbid"});
            break;
          case 7:
            region.push_back({LabelShape{"_SEG", labels->by_face[random() % faces]}, "forbid"});
            break;
          case 2:
            region.push_back({SphereShape{place(), 0.5 * unit() * norm(size)}, "forbid"});
            break;
          default: {
            const Vec3 a = place();
            const Vec3 b = a + Vec3{unit() * size.x, unit() * size.y, unit() * size.z};
            region.push_back({BoxShape{a, b}, "forbid"});
          }
        }
      }
      return region;
    };
    const Regions regions{draw_region(), draw_region(), {}};
    std::vector<std::uint32_t> expected;
    for (std::uint32_t f = 0; f < faces; ++f) {
      const bool is_within = regions.within.empty() || has(regions.within, f);
      if (is_within && !has(regions.forbid, f)) expected.push_back(f);
    }
    const auto cut = cut_regions(mesh, regions, file, Cancel());
    if (expected.empty()) {
      REQUIRE_FALSE(cut);
      CHECK(cut.error().code == ErrorCode::value_out_of_range);
      CHECK(cut.error().parameter == (regions.forbid.empty() ? "within" : "forbid"));
    } else {
      CHECK(left_of(cut) == expected);
    }
  }
}

TEST_CASE("FacesAndPartsThatAreNotThereAreRefused") {
  const Mesh mesh = mesh_of(shapes::plane(4, 4));  // 18 faces
  FileFaces file;
  file.parts = {{{0, 18, "all"}}, 1, false};
  const auto check = [&](const char* text, const char* parameter, std::uint64_t limit) {
    CAPTURE(text);
    const auto cut = cut_regions(mesh, *forbid(text), file, Cancel());
    REQUIRE_FALSE(cut);
    CHECK(cut.error().code == ErrorCode::index_out_of_range);
    CHECK(cut.error().parameter == parameter);
    CHECK(cut.error().limit == limit);
  };
  check("faces:1,18", "forbid.faces[1]", 17);
  check("faces:0-18446744073709551615", "forbid.faces[0]", 17);
  check("part:1", "forbid.part", 0);
  CHECK(left_of(cut_regions(mesh, *forbid("faces:1-17"), file, Cancel())) ==
        std::vector<std::uint32_t>{0});
  const auto none = cut_regions(mesh, *forbid("part:0"), {}, Cancel());
  REQUIRE_FALSE(none);
  CHECK(none.error().detail == "the mesh lists no parts");
}

TEST_CASE("NamesThatAreNotThereAreAnsweredWithTheNearest") {
  const Mesh mesh = mesh_of(shapes::plane(4, 4));
  FileFaces file;
  file.parts = {{{0, 9, "roof"}, {9, 9, ""}}, 2, false};
  FaceMaterials materials;
  const auto check = [&](const json& region, ErrorCode code, const char* parameter,
                         const char* detail) {
    CAPTURE(region.dump());
    const auto cut = cut_regions(mesh, *forbid(region), file, Cancel());
    REQUIRE_FALSE(cut);
    CHECK(cut.error().code == code);
    CHECK(cut.error().parameter == parameter);
    CHECK(cut.error().detail == detail);
  };
  const ErrorCode range = ErrorCode::value_out_of_range;
  const ErrorCode index = ErrorCode::index_out_of_range;
  check("part:rof", range, "forbid.part", R"(the mesh has no part "rof"; it has "roof")");
  check("material:glass", range, "forbid.material", "the mesh has no materials");
  check("material:0", index, "forbid.material", "the mesh lists no materials");
  for (const char* name : {"Glass", "", "brick", "glass pane", "Glass", "tar"}) {
    materials.add_name(name);
  }
  materials.add_faces(18, 0);
  file.materials = std::make_shared<const FaceMaterials>(materials);
  check("material:glas", range, "forbid.material",
        R"(the mesh has no material "glas"; the nearest names are "Glass", "tar", "brick")");
  check(
      "material:\xe2\x80\xae\n\x1b[2J", range, "forbid.material",
      "the mesh has no material \"?????[2J\"; the nearest names are \"Glass\", \"brick\", \"tar\"");
  check(json::array({"material:4", "material:6"}), index, "forbid[1].material",
        "the mesh lists no such material");
  // However long a name is, it is asked for as a whole or as clients read it.
  const std::string name(kMostNameBytes + 50, 'n');
  file.parts = {{{0, 9, told_name(name)}, {9, 9, "b"}}, 2, false};
  const std::vector<std::uint32_t> left{9, 10, 11, 12, 13, 14, 15, 16, 17};
  CHECK(left_of(cut_regions(mesh, *forbid("part:" + name), file, Cancel())) == left);
  CHECK(left_of(cut_regions(mesh, *forbid("part:" + told_name(name)), file, Cancel())) == left);
  CHECK(cut_regions(mesh, *forbid("part:" + std::string(5000, 'm')), file, Cancel())
            .error()
            .detail.size() < 500);
  // Of parts that are not listed nobody knows the name.
  file.parts.total = 3;
  check("part:b", ErrorCode::too_large, "forbid.part",
        "the mesh has more parts than have numbers, so that not all of a name are known; say parts "
        "by number, or faces");
  CHECK(cut_regions(mesh, *forbid("part:1"), file, Cancel()));
  // Nor of materials; numbers are known, and so is what has none.
  REQUIRE(cut_regions(mesh, *forbid("material:Glass"), file, Cancel()).error().code == range);
  materials = {};
  for (const char* name : {"glass", "brick"}) materials.add_name(name);
  materials.add_faces(5, 0);
  materials.add_faces(4, 2);
  materials.add_faces(1, kNoMaterial);
  file.materials = std::make_shared<const FaceMaterials>(materials);
  for (const char* name : {"material:glass", "material:brick", "material:tar"}) {
    check(name, ErrorCode::too_large, "forbid.material",
          "the mesh has more materials than have numbers, so that not all of a name are known; say "
          "materials by number, or faces");
    CHECK(cut_regions(mesh, *forbid(name), file, Cancel()).error().limit == 2);
    CHECK(cut_regions(mesh, *forbid(name), file, Cancel()).error().actual == 3);
  }
  CHECK(left_of(cut_regions(mesh, *forbid("material:0"), file, Cancel())).size() == 13);
  CHECK(left_of(cut_regions(mesh, *forbid("material:none"), file, Cancel())).size() == 9);
}

TEST_CASE("GoingThroughRegionsStopsWhenItIsToldTo") {
  const Mesh mesh = mesh_of(shapes::plane(120, 120));
  const Regions regions = *regions_of(
      R"({"within":["box:0,0,0,200,200,1","sphere:50,50,0,60"],"forbid":"faces:0-9000,100-20000"})");
  int questions = 0;
  REQUIRE(cut_regions(mesh, regions, {}, Cancel([&] { return ++questions < 0; })));
  for (int stop_at = 1; stop_at <= questions; ++stop_at) {
    int asked = 0;
    const auto cut = cut_regions(mesh, regions, {}, Cancel([&] { return ++asked >= stop_at; }));
    REQUIRE_FALSE(cut);
    CHECK(cut.error().code == ErrorCode::cancelled);
  }
}
