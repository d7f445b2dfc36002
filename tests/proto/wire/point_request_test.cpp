#include "proto/wire/point_request.h"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "proto/wire/input_codes.h"
#include "proto/wire/parameters.h"

using namespace geodesic;
using namespace geodesic::proto;
using nlohmann::json;

namespace {

const RayRequest& ray_of(const Result<PointRequest>& point) {
  REQUIRE(point);
  REQUIRE(std::holds_alternative<RayRequest>(point->where));
  return std::get<RayRequest>(point->where);
}

template <class T>
void check_refused(const Result<T>& read, ErrorCode code, const std::string& parameter) {
  REQUIRE_FALSE(read);
  CHECK(read.error().code == code);
  CHECK(read.error().parameter == parameter);
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

TEST_CASE("ANumberThatIsWholeIsOneHoweverItIsWritten") {
  for (const char* one : {"1", "1.0", "1e0", "10e-1", "0.1e1", "1.000E+0"}) {
    CAPTURE(one);
    const std::string text(one);
    const auto vertex = parse_json_point(json::parse("{\"vertex\":" + text + "}"), "to");
    REQUIRE(vertex);
    CHECK(std::get<VertexRequest>(vertex->where).vertex == 1);
    const auto face =
        parse_json_point(json::parse("{\"face\":" + text + ",\"bary\":[1,0,0]}"), "to");
    REQUIRE(face);
    CHECK(std::get<FaceRequest>(face->where).face == 1);
    auto parameters = Parameters::from_json("{\"precision\":" + text + "}");
    REQUIRE(parameters);
    CHECK(parameters->whole("precision").value() == 1);
  }
  for (const char* zero : {"-0", "-0.0", "0e9", "0.0"}) CHECK(whole_number(json::parse(zero)) == 0);
  CHECK(whole_number(json::parse("18446744073709551615")) == 18446744073709551615ULL);
  CHECK(whole_number(json::parse("9007199254740993")) == 9007199254740993ULL);  // no double
  CHECK(whole_number(json::parse("1e19")) == 10000000000000000000ULL);
  for (const char* none : {"-1", "-1.0", "0.5", "1.5e0", "18446744073709551616", "1e300", "\"1\"",
                           "true", "null", "[1]", "{}"}) {
    CAPTURE(none);
    CHECK_FALSE(whole_number(json::parse(none)));
    check_refused(parse_json_point(json::parse("{\"vertex\":" + std::string(none) + "}"), "to"),
                  InputCode::bad_syntax, "to.vertex");
  }
}

TEST_CASE("AListIsNoScalarHoweverShort") {
  const auto read = [](const char* body) {
    auto parameters = Parameters::from_json(body);
    REQUIRE(parameters);
    return std::move(*parameters);
  };
  for (const char* list : {"{\"a\":[\"1\"]}", "{\"a\":[1]}", "{\"a\":[true]}", "{\"a\":[\"v:1\"]}",
                           "{\"a\":[]}", "{\"a\":[1,1]}", "{\"a\":[\"1,0,0\"]}"}) {
    CAPTURE(list);
    Parameters p = read(list);
    check_refused(p.number("a"), InputCode::bad_syntax, "a");
    check_refused(p.whole("a"), InputCode::bad_syntax, "a");
    check_refused(p.text("a"), InputCode::bad_syntax, "a");
    check_refused(p.scalar("a"), InputCode::bad_syntax, "a");
    check_refused(p.flag("a"), InputCode::bad_syntax, "a");
    check_refused(p.point("a"), InputCode::bad_syntax, "a");
    check_refused(p.vector("a"), InputCode::bad_syntax, "a");
  }
  // Where a list may stand, one of one may.
  CHECK(read("{\"a\":[\"v:1\"]}").points("a").value().size() == 1);
  CHECK(read("{\"a\":[1]}").numbers("a").value().size() == 1);
  CHECK(read("{\"a\":[1,0,0]}").vector("a").value()->x == 1);
  CHECK(read("{\"a\":\"1,0,0\"}").vector("a").value()->x == 1);
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
