#include "proto/region/region.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/region/cut_regions.h"
#include "proto/region/read_regions.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/query_limits.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using namespace geodesic::proto;
using nlohmann::json;

namespace {

Result<Regions> read(const std::string& body) {
  auto parameters = Parameters::from_json(body);
  REQUIRE(parameters);
  return read_regions(*parameters);
}

Result<Regions> forbid(const json& region) { return read(json{{"forbid", region}}.dump()); }

std::string text_of(const Result<Regions>& regions) {
  REQUIRE(regions);
  return canonical_text(*regions);
}

void refused(const Result<Regions>& regions, ErrorCode code, std::string_view parameter) {
  CAPTURE(parameter);
  REQUIRE_FALSE(regions);
  CHECK(regions.error().code.name() == code.name());
  CHECK(regions.error().parameter == parameter);
  CHECK_FALSE(regions.error().detail.empty());
}

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

TEST_CASE("ARegionIsTheSameInAUrlAndInJson") {
  const std::vector<std::pair<std::string, std::string>> kBoth{
      {"faces:7", R"({"faces":[7]})"},
      {"faces:7,10-99,3", R"({"faces":[7,[10,99],[3,3]]})"},
      {"part:2", R"({"part":2})"},
      {"sphere:1,-2.5,3e2,0", R"({"sphere":{"center":[1,-2.5,300],"radius":0}})"},
      {"box:0,0,0,1,2,3", R"({"box":{"min":[0,0,0],"max":[1,2,3.0]}})"},
      {"inside:v:1;f:2,0.25,0.5;p:1,2,3;ray:0,0,9,0,0,-1",
       R"({"inside":["v:1",{"face":2,"bary":[0.25,0.5,0.25]},{"xyz":[1,2,3]},
           {"ray":{"origin":[0,0,9],"direction":[0,0,-1]}}]})"}};
  for (const auto& both : kBoth) {
    const std::string& text = both.first;
    CAPTURE(text);
    const std::string known = text_of(forbid(json::parse(both.second)));
    CHECK(known == text_of(forbid(text)));
    CHECK(known == text_of(forbid(json::array({text}))));
    Parameters url = Parameters::from_query({{"forbid", text}});
    CHECK(known == text_of(read_regions(url)));
    CHECK(known != text_of(read(json{{"within", text}}.dump())));
    CHECK(known != text_of(forbid(json::array({text, "faces:1000"}))));
  }
  CHECK(text_of(read("{}")) == canonical_text(Regions{}));
  CHECK(read("{}")->is_everything());
  CHECK_FALSE(forbid("faces:1")->is_everything());
  CHECK(forbid(json::array({"faces:1", "part:0"}))->names_parts());
  CHECK_FALSE(forbid("faces:1")->names_parts());
}

TEST_CASE("AWallIsTheSameInAUrlAndInJson") {
  const auto walls = [](const json& value) { return read(json{{"walls", value}}.dump()); };
  const std::string known = text_of(walls(json::parse(R"({"points":["v:1",{"vertex":2}]})")));
  CHECK(known == text_of(walls("v:1;v:2")));
  CHECK(known == text_of(walls(json::array({"v:1;v:2"}))));
  Parameters url = Parameters::from_query({{"walls", "v:1;v:2"}});
  CHECK(known == text_of(read_regions(url)));
  for (const json& other :
       {json("v:2;v:1"), json("v:1;v:2;v:1"), json("v:1;f:2,0.5,0.5"), json("v:12;v:2"),
        json::array({"v:1;v:2", "v:1;v:2"}), json("p:1,2,3;v:2"),
        json::parse(R"({"points":["v:1",{"xyz":[1,2,3]}]})"),
        json::parse(R"({"points":["v:1",{"xyz":[1,2,3],"max_snap":1}]})")}) {
    CHECK(known != text_of(walls(other)));
  }
  CHECK(walls("v:1;v:2")->has_lines());
  CHECK_FALSE(walls("v:1;v:2")->is_everything());
  CHECK(forbid("inside:v:1;v:2;v:3")->has_lines());
  CHECK_FALSE(forbid("faces:1")->has_lines());
  const ErrorCode syntax = InputCode::bad_syntax;
  const ErrorCode range = ErrorCode::value_out_of_range;
  refused(walls("v:1"), range, "walls");
  refused(walls(""), syntax, "walls.points[0]");
  refused(walls(json::array({"v:1;v:2", "v:1;v:x"})), syntax, "walls[1].points[1]");
  refused(walls(json::array()), range, "walls");
  refused(walls(7), syntax, "walls");
  refused(walls(json::object()), syntax, "walls");
  refused(walls({{"points", "v:1;v:2"}}), syntax, "walls.points");
  refused(walls({{"points", {"v:1", 2}}}), syntax, "walls.points[1]");
  refused(walls({{"points", {"v:1", "v:2"}}, {"closed", true}}), InputCode::unknown_parameter,
          "walls.closed");
  refused(walls({{"points", {"v:1", {{"vertex", 2}, {"offset", 1}}}}}), range,
          "walls.points[1].offset");
  refused(forbid("inside:v:1;v:2"), range, "forbid.inside");
  refused(forbid("inside:"), syntax, "forbid.inside[0]");
  refused(forbid(json::parse(R"({"inside":"v:1"})")), syntax, "forbid.inside");
  // All lines of a query are counted together.
  json half = json::array();
  for (std::size_t i = 0; i <= kMaxLinePoints / 2; ++i) half.push_back("v:1");
  refused(read(json{{"forbid", {{"inside", half}}}, {"walls", {{"points", half}}}}.dump()),
          ErrorCode::too_large, "walls");
  CHECK(walls({{"points", half}}));
  json many = json::array();
  for (std::size_t i = 0; i <= kMaxWalls; ++i) many.push_back("v:1;v:2");
  refused(walls(many), ErrorCode::too_large, "walls");
}

TEST_CASE("RegionsThatAreNoneAreRefusedByName") {
  const ErrorCode syntax = InputCode::bad_syntax;
  const ErrorCode range = ErrorCode::value_out_of_range;
  for (const char* text :
       {"", "faces", "faces:", "faces:a", "faces:-1", "faces:1-", "faces:1,,2", "faces:1 ",
        "part:", "part:-1", "part:1.5", "sphere:1,2,3", "sphere:1,2,3,4,5", "sphere:1,2,3,nan",
        "sphere:1,2,3,inf", "box:1,2,3", "box:1,2,3,4,5,nan", "ball:1,2,3,4"}) {
    CAPTURE(text);
    refused(forbid(text), syntax, "forbid");
  }
  refused(forbid("faces:9-3"), range, "forbid.faces[0]");
  refused(forbid(json::array({"faces:1", "faces:1,9-3"})), range, "forbid[1].faces[1]");
  refused(forbid("sphere:1,2,3,-1"), range, "forbid.sphere.radius");
  refused(forbid("sphere:1e61,2,3,1"), range, "forbid.sphere.center");
  refused(forbid("box:0,0,0,1,1,-1"), range, "forbid.box");
  refused(forbid("box:0,-1e61,0,1,1,1"), range, "forbid.box.min");
  refused(forbid("box:0,0,0,1,1e61,1"), range, "forbid.box.max");
  refused(forbid(json::array()), range, "forbid");
  refused(read(R"({"within":[]})"), range, "within");
  const auto in_json = [&](const char* text, ErrorCode code, const char* parameter) {
    CAPTURE(text);
    refused(forbid(json::parse(text)), code, parameter);
  };
  in_json("7", syntax, "forbid");
  in_json("null", syntax, "forbid");
  in_json("{}", syntax, "forbid");
  in_json(R"({"faces":7})", syntax, "forbid.faces");
  in_json(R"({"faces":[]})", range, "forbid");
  in_json(R"({"faces":[[1,2,3]]})", syntax, "forbid.faces[0]");
  in_json(R"({"faces":[1,[2,1.5]]})", syntax, "forbid.faces[1]");
  in_json(R"({"faces":[-1]})", syntax, "forbid.faces[0]");
  in_json(R"({"faces":[1],"part":2})", InputCode::unknown_parameter, "forbid.part");
  in_json(R"({"part":"2"})", syntax, "forbid.part");
  in_json(R"({"sphere":7})", syntax, "forbid.sphere");
  in_json(R"({"sphere":{"center":[1,2,3]}})", syntax, "forbid.sphere");
  in_json(R"({"sphere":{"center":[1,2],"radius":1}})", syntax, "forbid.sphere.center");
  in_json(R"({"sphere":{"center":[1,2,3],"radius":"1"}})", syntax, "forbid.sphere.radius");
  in_json(R"({"sphere":{"center":[1,2,3],"radius":1,"x":2}})", InputCode::unknown_parameter,
          "forbid.sphere.x");
  in_json(R"({"box":{"min":[1,2,3],"max":7}})", syntax, "forbid.box.max");
  in_json(R"({"box":{"min":null,"max":[1,2,3]}})", syntax, "forbid.box.min");
}

TEST_CASE("RegionsAreBounded") {
  json many = json::array();
  for (std::size_t i = 0; i < kMaxRegionShapes; ++i) many.push_back("faces:1");
  CHECK(forbid(many));
  many.push_back("faces:1");
  refused(forbid(many), ErrorCode::too_large, "forbid");
  CHECK(forbid(many).error().limit == kMaxRegionShapes);
  CHECK(forbid(many).error().actual == kMaxRegionShapes + 1);
  const json half{{"faces", std::vector<int>(kMaxFaceRanges / 2, 3)}};
  CHECK(read(json{{"within", half}, {"forbid", half}}.dump()));
  const json more{{"faces", std::vector<int>(kMaxFaceRanges / 2 + 1, 3)}};
  refused(read(json{{"within", half}, {"forbid", more}}.dump()), ErrorCode::too_large, "forbid");
}

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
    const std::vector<PartFaces> parts{{0, faces / 3}, {faces / 3, 0}, {faces / 3, faces}};
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
          const auto& [first, count] = parts[part->part];
          if (first <= f && f < first + count) return true;
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
        switch (random() % 4) {
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
    const auto cut = cut_regions(mesh, regions, parts, Cancel());
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
  const std::vector<PartFaces> parts{{0, 18}};
  const auto check = [&](const char* text, const char* parameter, std::uint64_t limit) {
    CAPTURE(text);
    const auto cut = cut_regions(mesh, *forbid(text), parts, Cancel());
    REQUIRE_FALSE(cut);
    CHECK(cut.error().code == ErrorCode::index_out_of_range);
    CHECK(cut.error().parameter == parameter);
    CHECK(cut.error().limit == limit);
  };
  check("faces:1,18", "forbid.faces[1]", 17);
  check("faces:0-18446744073709551615", "forbid.faces[0]", 17);
  check("part:1", "forbid.part", 0);
  CHECK(left_of(cut_regions(mesh, *forbid("faces:1-17"), parts, Cancel())) ==
        std::vector<std::uint32_t>{0});
  const auto none = cut_regions(mesh, *forbid("part:0"), {}, Cancel());
  REQUIRE_FALSE(none);
  CHECK(none.error().detail == "the mesh lists no parts");
}

TEST_CASE("GoingThroughRegionsStopsWhenItIsToldTo") {
  const Mesh mesh = mesh_of(shapes::plane(120, 120));
  const Regions regions = *read(
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
