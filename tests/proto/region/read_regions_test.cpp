// Regions and walls as clients write them: which spellings mean the same, and what is refused.
#include "proto/region/read_regions.h"

#include <doctest/doctest.h>

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "proto/region/region.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/parameters.h"
#include "proto/wire/query_limits.h"
#include "tests/proto/region/asked_regions.h"

using namespace geodesic;
using namespace geodesic::proto;
using nlohmann::json;

namespace {

std::string region_text(const Result<Regions>& regions) {
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
    const std::string known = region_text(forbid(json::parse(both.second)));
    CHECK(known == region_text(forbid(text)));
    CHECK(known == region_text(forbid(json::array({text}))));
    Parameters url = Parameters::from_query({{"forbid", text}});
    CHECK(known == region_text(read_regions(url)));
    CHECK(known != region_text(regions_of(json{{"within", text}}.dump())));
    CHECK(known != region_text(forbid(json::array({text, "faces:1000"}))));
  }
  CHECK(region_text(regions_of("{}")) == canonical_text(Regions{}));
  CHECK(regions_of("{}")->is_everything());
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
      CHECK((region_text(forbid(one)) == region_text(forbid(other))) == (&one == &other));
    }
  }
}

TEST_CASE("AWallIsTheSameInAUrlAndInJson") {
  const auto walls = [](const json& value) { return regions_of(json{{"walls", value}}.dump()); };
  const std::string known = region_text(walls(json::parse(R"({"points":["v:1",{"vertex":2}]})")));
  CHECK(known == region_text(walls("v:1;v:2")));
  CHECK(known == region_text(walls(json::array({"v:1;v:2"}))));
  Parameters url = Parameters::from_query({{"walls", "v:1;v:2"}});
  CHECK(known == region_text(read_regions(url)));
  for (const json& other :
       {json("v:2;v:1"), json("v:1;v:2;v:1"), json("v:1;f:2,0.5,0.5"), json("v:12;v:2"),
        json::array({"v:1;v:2", "v:1;v:2"}), json("p:1,2,3;v:2"),
        json::parse(R"({"points":["v:1",{"xyz":[1,2,3]}]})"),
        json::parse(R"({"points":["v:1",{"xyz":[1,2,3],"max_snap":1}]})")}) {
    CHECK(known != region_text(walls(other)));
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
  refused(regions_of(json{{"forbid", {{"inside", half}}}, {"walls", {{"points", half}}}}.dump()),
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
  const auto walls = [](const json& value) { return regions_of(json{{"walls", value}}.dump()); };
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
  refused(regions_of(R"({"within":[]})"), range, "within");
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
  CHECK(regions_of(json{{"within", half}, {"forbid", half}}.dump()));
  const json more{{"faces", std::vector<int>(kMaxFaceRanges / 2 + 1, 3)}};
  refused(regions_of(json{{"within", half}, {"forbid", more}}.dump()), ErrorCode::too_large,
          "forbid");
}
