#include "proto/region/region.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/region/costs.h"
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
      {"part:roof", R"({"part":"roof"})"},
      {"part:\"2\"", R"({"part":"2"})"},
      {"part:\"\"", R"({"part":""})"},
      {"part:none", R"({"part":"none"})"},
      {"part:-1", R"({"part":"-1"})"},
      {"material:3", R"({"material":3})"},
      {"material:007", R"({"material":7})"},
      {"material:\"3\"", R"({"material":"3"})"},
      {"material:glass", R"({"material":"glass"})"},
      {"material:\"glass\"", R"({"material":"glass"})"},
      {"material:none", R"({"material":null})"},
      {"material:\"none\"", R"({"material":"none"})"},
      {"material:None", R"({"material":"None"})"},
      {"material: a,b;c:d*e=f&g faces:1 ", R"({"material":" a,b;c:d*e=f&g faces:1 "})"},
      {"material:\"", R"({"material":"\""})"},
      {"material:\"\"a\"\"", R"({"material":"\"a\""})"},
      {"material:\"half", R"({"material":"\"half"})"},
      {"material:\xc3\xa4\n", R"({"material":"\u00e4\n"})"},
      {"label:_A=B=-1.50", R"({"label":{"attribute":"_A=B","value":-1.5}})"},
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
  const auto named = [](const json& region) { return forbid(region)->named_of_file(); };
  CHECK(named(json::array({"faces:1", "part:0"})).parts);
  CHECK_FALSE(named(json::array({"faces:1", "part:0"})).materials);
  CHECK(named("material:none").materials);
  CHECK_FALSE(named("material:none").parts);
  CHECK_FALSE(named("faces:1").parts);
  CHECK_FALSE(named("faces:1").materials);
  CHECK(named("faces:1").labels.empty());
  const auto labels = named(json::array({"label:_A=1", "label:_B=1", "label:_A=2"})).labels;
  CHECK(labels ==
        std::map<std::string, std::string>{{"_A", "forbid[0].label"}, {"_B", "forbid[1].label"}});
}

// Where one name ends and another shape begins, no two regions have one text.
TEST_CASE("NamesCannotPassForOtherRegions") {
  const std::vector<json> regions{json::array({"material:a", "material:b"}),
                                  json::array({"material:a material,1:b"}),
                                  json::array({"material:1"}),
                                  json::array({"material:\"1\""}),
                                  json::array({"material:none"}),
                                  json::array({"material:\"none\""}),
                                  json::array({"label:a=1", "label:b=1"}),
                                  json::array({"label:a=1 label,1:b=1"}),
                                  json::array({"label:a=2", "label:b=1"}),
                                  json::array({"part:1"}),
                                  json::array({"part:\"1\""}),
                                  json::array({"material:1:1"}),
                                  json::array({"material:a", "faces:1"}),
                                  json::array({"material:a faces,1-1"}),
                                  json::array({"material:\"\"", "material:a"})};
  for (const json& one : regions) {
    for (const json& other : regions) {
      CHECK((text_of(forbid(one)) == text_of(forbid(other))) == (&one == &other));
    }
  }
}

TEST_CASE("WeightsOfTheFileGoByTheirAttributeAndThoseSentByTheirNumbers") {
  const auto of_file = [](const std::string& attribute) {
    Costs costs;
    costs.weight_attribute = attribute;
    return costs;
  };
  Costs read = of_file("_MUD");
  read.face_weights.assign(100'000, 1.5);
  CHECK_FALSE(of_file("_MUD").are_lengths());
  CHECK(canonical_text(read) == canonical_text(of_file("_MUD")));
  CHECK(canonical_text(read).size() < 200);
  // Whatever is in a name, it passes for nothing else.
  Costs sent;
  sent.face_weights = {1.5};
  Costs more = of_file("_MUD");
  more.weights.push_back({{std::vector<FaceRange>{{1, 1}}, "weights[0]"}, 3});
  Costs by_label = of_file("_MUD");
  by_label.weights.push_back({{LabelShape{"_MUD", 1}, "weights[0]"}, 3});
  const std::vector<Costs> all{Costs{},
                               sent,
                               of_file("_MUD"),
                               of_file("_MUD2"),
                               of_file("_MUD weight 3 within faces,1-1 forbid"),
                               of_file("faces 1.5"),
                               more,
                               by_label};
  for (const Costs& one : all) {
    for (const Costs& other : all) {
      CHECK((canonical_text(one) == canonical_text(other)) == (&one == &other));
    }
  }
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

// None of these is a point: of lines that are too long, none is looked at.
TEST_CASE("PointsOfLinesAreCountedBeforeTheyAreMade") {
  const std::string text(kMaxLinePoints, ';');
  const json list(std::vector<int>(kMaxLinePoints + 1, 7));
  const ErrorCode large = ErrorCode::too_large;
  const auto walls = [](const json& value) { return read(json{{"walls", value}}.dump()); };
  for (const auto& [got, parameter] : std::vector<std::pair<Result<Regions>, std::string>>{
           {walls(text), "walls"},
           {walls({{"points", list}}), "walls"},
           {forbid("inside:" + text), "forbid"},
           {forbid({{"inside", list}}), "forbid"}}) {
    refused(got, large, parameter);
    CHECK(got.error().limit == kMaxLinePoints);
    CHECK(got.error().actual == kMaxLinePoints + 1);
  }
  // One point fewer is looked at.
  refused(walls(text.substr(1)), InputCode::bad_syntax, "walls.points[0]");
  refused(forbid("inside:" + text.substr(1)), InputCode::bad_syntax, "forbid.inside[0]");
  // Those of other lines are counted, too.
  const std::string two = "v:1;v:2";
  const json second = json::array({two, text.substr(2)});
  refused(walls(second), large, "walls");
  CHECK(walls(second).error().actual == kMaxLinePoints + 1);
  // Shapes that are read one by one.
  const auto shape = parse_shape("inside:" + text, "weights[0]");
  REQUIRE_FALSE(shape);
  CHECK(shape.error().code == large);
  const auto in_json = parse_json_shape({{"inside", list}}, "weights[0].region");
  REQUIRE_FALSE(in_json);
  CHECK(in_json.error().code == large);
  CHECK(in_json.error().parameter == "weights[0].region.inside");
}

TEST_CASE("RegionsThatAreNoneAreRefusedByName") {
  const ErrorCode syntax = InputCode::bad_syntax;
  const ErrorCode range = ErrorCode::value_out_of_range;
  for (const char* text : {"",
                           "faces",
                           "faces:",
                           "faces:a",
                           "faces:-1",
                           "faces:1-",
                           "faces:1,,2",
                           "faces:1 ",
                           "part:",
                           "part",
                           "part:99999999999999999999",
                           "material",
                           "material:",
                           "material:99999999999999999999",
                           "sphere:1,2,3",
                           "sphere:1,2,3,4,5",
                           "sphere:1,2,3,nan",
                           "sphere:1,2,3,inf",
                           "box:1,2,3",
                           "box:1,2,3,4,5,nan",
                           "ball:1,2,3,4"}) {
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
  for (const char* none : {"-1", "1.5", "null", "true", "[2]", "{}"}) {
    in_json((R"({"part":)" + std::string(none) + "}").c_str(), syntax, "forbid.part");
  }
  for (const char* none : {"-1", "1.5", "true", "[2]", "{}"}) {
    in_json((R"({"material":)" + std::string(none) + "}").c_str(), syntax, "forbid.material");
  }
  in_json(R"({"material":"a","part":2})", InputCode::unknown_parameter, "forbid.material");
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
