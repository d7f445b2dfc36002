#include "proto/wire/point_request.h"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "proto/wire/input_codes.h"

using namespace geodesic;
using namespace geodesic::proto;
using nlohmann::json;

namespace {

const RayRequest& ray_of(const Result<PointRequest>& point) {
  REQUIRE(point);
  REQUIRE(std::holds_alternative<RayRequest>(point->where));
  return std::get<RayRequest>(point->where);
}

void check_refused(const Result<PointRequest>& point, ErrorCode code,
                   const std::string& parameter) {
  REQUIRE_FALSE(point);
  CHECK(point.error().code == code);
  CHECK(point.error().parameter == parameter);
}

}  // namespace

TEST_CASE("ARayIsReadFromAUrlAndFromJson") {
  const auto text = parse_point("ray:1,-2.5,3e2,0,0,-4", "from[2]");
  CHECK(ray_of(text).origin == Vec3{1, -2.5, 300});
  CHECK(ray_of(text).direction == Vec3{0, 0, -4});
  CHECK(text->parameter == "from[2]");
  CHECK(text->offset == 0);

  const auto object = parse_json_point(
      json::parse(R"({"ray":{"origin":[1,-2.5,300],"direction":[0,0,-4]},"offset":2})"), "from[0]");
  CHECK(ray_of(object).origin == ray_of(text).origin);
  CHECK(ray_of(object).direction == ray_of(text).direction);
  CHECK(object->offset == 2);

  const auto as_text = parse_json_point(json("ray:1,-2.5,3e2,0,0,-4"), "from[0]");
  CHECK(ray_of(as_text).direction == Vec3{0, 0, -4});
}

TEST_CASE("ARayNeedsADirectionAndFiniteNumbers") {
  check_refused(parse_point("ray:1,2,3,0,0,0", "to"), ErrorCode::value_out_of_range, "to");
  check_refused(parse_point("ray:1,2,3,0,-0,0.0", "to"), ErrorCode::value_out_of_range, "to");
  check_refused(
      parse_json_point(json::parse(R"({"ray":{"origin":[0,0,0],"direction":[0,0,0]}})"), "to"),
      ErrorCode::value_out_of_range, "to");
  for (const char* text : {"ray:inf,0,0,1,0,0", "ray:0,0,0,nan,0,0", "ray:0,0,0,-inf,0,0",
                           "ray:0,0,0,1e999,0,0", "ray:0,0,1e400,1,0,0"}) {
    CAPTURE(text);
    check_refused(parse_point(text, "at[1]"), ErrorCode::value_out_of_range, "at[1]");
  }
  // However small or large it is, a direction is one.
  CHECK(ray_of(parse_point("ray:0,0,0,1e-300,0,0", "to")).direction.x == 1e-300);
  CHECK(ray_of(parse_point("ray:0,0,0,0,1e300,0", "to")).direction.y == 1e300);
}

TEST_CASE("WhatIsNoRayIsBadSyntax") {
  for (const char* text :
       {"ray:", "ray:1,2,3", "ray:1,2,3,0,0", "ray:1,2,3,0,0,1,", "ray:1,2,3,0,0,1,2",
        "ray:1,2,3,0,0,x", "ray:1;2;3;0;0;1", "ray: 1,2,3,0,0,1", "ray:1,2,3,0,0,1 ", "ray:,,,,,",
        "ray:1,,3,0,0,1", "ray:+1,2,3,0,0,1", "ray:0x1,2,3,0,0,1", "ray", "RAY:1,2,3,0,0,1",
        "ray=1,2,3,0,0,1"}) {
    CAPTURE(text);
    check_refused(parse_point(text, "to"), InputCode::bad_syntax, "to");
  }
  const auto refused = [](const char* text, ErrorCode code, const char* parameter) {
    CAPTURE(text);
    check_refused(parse_json_point(json::parse(text), "to"), code, parameter);
  };
  refused(R"({"ray":[0,0,9,0,0,-1]})", InputCode::bad_syntax, "to.ray");
  refused(R"({"ray":{}})", InputCode::bad_syntax, "to.ray.origin");
  refused(R"({"ray":{"origin":[0,0,9]}})", InputCode::bad_syntax, "to.ray.direction");
  refused(R"({"ray":{"origin":[0,0],"direction":[0,0,1]}})", InputCode::bad_syntax,
          "to.ray.origin");
  refused(R"({"ray":{"origin":[0,0,1],"direction":["0",0,1]}})", InputCode::bad_syntax,
          "to.ray.direction");
  refused(R"({"ray":{"origin":[0,0,1],"direction":[0,0,1],"length":1}})",
          InputCode::unknown_parameter, "to.ray.length");
  refused(R"({"ray":{"origin":[0,0,1],"direction":[0,0,1]},"max_snap":1})",
          InputCode::unknown_parameter, "to.max_snap");
  refused(R"({"ray":{"origin":[0,0,1],"direction":[0,0,1]},"offset":-1})",
          ErrorCode::value_out_of_range, "to.offset");
}

TEST_CASE("TheOtherPointsAreReadAsBefore") {
  const auto vertex = parse_point("v:12", "to");
  REQUIRE(vertex);
  CHECK(std::get<VertexRequest>(vertex->where).vertex == 12);
  const auto face = parse_point("f:40,0.25,0.25", "to");
  REQUIRE(face);
  CHECK(std::get<FaceRequest>(face->where).bary == std::array{0.25, 0.25, 0.5});
  const auto space = parse_json_point(json::parse(R"({"xyz":[1,2,3],"max_snap":0.5})"), "to");
  REQUIRE(space);
  CHECK(std::get<SpaceRequest>(space->where).max_snap == 0.5);
  check_refused(parse_json_point(json::parse(R"({"vertex":1,"max_snap":1})"), "to"),
                InputCode::unknown_parameter, "to.max_snap");
}
