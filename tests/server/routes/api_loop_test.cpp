#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "tests/fixtures/tube.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// A tube of 12 sides and 4 rows, and one ring of it.
struct TubeService : PlaneService {
  TubeService() { base = add(fixtures::tube(12, 4, 4)); }
};
const double kRing = 24 * std::sin(std::numbers::pi / 12);

}  // namespace

TEST_CASE("ALoopThroughPointsIsThePathsBetweenThem") {
  PlaneService plane;  // a vertex at each whole x below 12 and y below 10
  const json reply = plane.ask("/loop?through=v:0&through=v:3&through=v:51&method=exact");
  CHECK(reply["mesh"] == plane.id);
  CHECK(reply["method"] == "exact");
  CHECK(reply["start"] == "through");
  REQUIRE(reply["through"].size() == 3);
  CHECK(reply["through"][2]["vertex"] == 51);
  CHECK(reply["length"] == doctest::Approx(12));  // 3, 4 and 5
  CHECK(reply["start_length"] == reply["length"]);
  CHECK(reply["geodesic"] == false);
  CHECK(reply["turn"] == doctest::Approx(180 - std::atan2(3, 4) * 180 / std::numbers::pi));
  const json& points = reply["points"];
  CHECK(points.front()["xyz"] == points.back()["xyz"]);
  CHECK(points[0]["xyz"] == json::parse("[0,0,0]"));
  CHECK(length_of(points) == doctest::Approx(12));
  const json path = plane.ask("/path?from=v:0&via=v:3&via=v:51&to=v:0&method=exact");
  CHECK(reply["length"] == path["length"]);
  CHECK(points == path["points"]);
  CHECK_FALSE(reply.contains("at"));
  CHECK_FALSE(reply.contains("hull"));
}

TEST_CASE("ASectionIsTightenedToARing") {
  TubeService tube;
  const json reply = tube.ask("/loop?at=v:30&normal=0.3,0.1,1");
  CHECK(reply["start"] == "plane");
  CHECK(reply["at"]["vertex"] == 30);
  CHECK(reply["normal"] == json::parse("[0.3,0.1,1]"));
  CHECK(reply["hull"] == false);
  CHECK_FALSE(reply.contains("method"));
  CHECK(reply["length"] == doctest::Approx(kRing));
  CHECK(reply["start_length"] > reply["length"]);
  CHECK(reply["geodesic"] == true);
  CHECK(reply["turn"] < 1e-4);
  CHECK(length_of(reply["points"]) == doctest::Approx(kRing));
  CHECK(reply["points"].front()["xyz"] == reply["points"].back()["xyz"]);
}

TEST_CASE("ALoopAroundPointsSlipsOffThem") {
  TubeService tube;
  const json reply = tube.ask("/loop?around=v:0&around=v:28&around=v:56");
  CHECK(reply["start"] == "around");
  CHECK(reply["around"].size() == 3);
  CHECK(reply["method"] == "auto");
  CHECK(reply["start_length"] > 1.05 * kRing);
  CHECK(reply["length"] == doctest::Approx(kRing));
  CHECK(reply["geodesic"] == true);
}

TEST_CASE("AHullIsInThePlaneAndRoundTheSection") {
  PlaneService plane;
  // A prism whose section is a square with a notch.
  TriangleSoup soup;
  const std::array<Vec3, 5> outline{{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 1, 0}, {0, 2, 0}}};
  for (const double z : {0.0, 1.0}) {
    for (const Vec3& p : outline) soup.positions.push_back({p.x, p.y, z});
  }
  for (std::uint32_t i = 0; i < 5; ++i) {
    const std::uint32_t j = (i + 1) % 5;
    soup.faces.push_back({i, j, j + 5});
    soup.faces.push_back({i, j + 5, i + 5});
  }
  const std::string base = plane.add(soup);
  const json reply = body_of(plane.service.get(base + "/loop?at=f:0,0.3,0.3&normal=0,0,3&hull=1"));
  CHECK(reply["hull"] == true);
  CHECK(reply["length"] == doctest::Approx(8));
  CHECK(reply["start_length"] == doctest::Approx(6 + 2 * std::sqrt(2)));
  CHECK(reply["geodesic"] == false);
  CHECK(reply["turn"].is_null());
  REQUIRE(reply["points"].size() == 5);
  for (const json& point : reply["points"]) {
    CHECK(point["xyz"][0] != 1);
    CHECK(point["face"].is_number());
  }
  // In a plane through three points, tilted by as much as makes one side longer.
  const json tilted = body_of(plane.service.get(
      base + "/loop?around=p:0.5,0,0.2&around=p:1.5,0,0.2&around=p:0,1.5,0.5&hull=1"));
  CHECK(tilted["start"] == "around");
  CHECK(tilted["hull"] == true);
  CHECK(tilted["around"].size() == 3);
  CHECK_FALSE(tilted.contains("method"));
  CHECK_FALSE(tilted.contains("normal"));
  CHECK(tilted["length"] == doctest::Approx(4 + 4 * std::hypot(1, 0.2)));
}

TEST_CASE("ATapeThroughThreePointsSaysWhyThereIsNone") {
  PlaneService plane;
  const std::string three = "/loop?around=v:0&around=v:5&around=v:77&hull=1";
  plane.check_refused(three, 422, "no_loop", "around");  // the plane of the plane
  plane.check_refused(three + "&around=v:9", 422, "value_out_of_range", "around");
  plane.check_refused(three + "&method=exact", 400, "unknown_parameter", "method");
  plane.check_refused("/loop?around=v:0&around=v:5&around=v:7&hull=1", 422, "value_out_of_range",
                      "around");
  plane.check_refused("/loop?around=v:0&around=v:5&around=v:5&hull=1", 422, "value_out_of_range",
                      "around");
  // Two tubes: the plane cuts both.
  TriangleSoup tubes;
  for (const double x : {0.0, 9.0}) {
    const auto first = static_cast<std::uint32_t>(tubes.positions.size());
    for (const double z : {0.0, 1.0}) {
      for (const Vec3& p : {Vec3{0, 0, 0}, Vec3{2, 0, 0}, Vec3{0, 2, 0}}) {
        tubes.positions.push_back({p.x + x, p.y, z});
      }
    }
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t j = (i + 1) % 3;
      tubes.faces.push_back({first + i, first + j, first + j + 3});
      tubes.faces.push_back({first + i, first + j + 3, first + i + 3});
    }
  }
  check_problem(
      plane.service.get(plane.add(tubes) +
                        "/loop?around=p:1,0,0.5&around=p:0,1,0.5&around=p:10,0,0.5&hull=1"),
      422, "no_loop", "around[2]");
}

TEST_CASE("LoopsInOtherFormats") {
  TubeService tube;
  const std::string target = tube.base + "/loop?at=v:30&normal=0.3,0.1,1";
  const json numbers = body_of(tube.service.get(target));
  const HttpResponse glb = tube.service.get(target + "&format=glb");
  REQUIRE(glb.status == 200);
  CHECK(glb.content_type == "model/gltf-binary");
  std::uint32_t length = 0;
  std::memcpy(&length, glb.body->data() + 12, sizeof length);
  const json gltf = json::parse(glb.body->substr(20, length));
  CHECK(gltf["nodes"][0]["name"] == "loop");
  CHECK(gltf["meshes"][0]["primitives"][0]["mode"] == 3);  // a line strip
  CHECK(gltf["accessors"][0]["count"] == numbers["points"].size());
  const HttpResponse array = tube.service.get(target + "&format=f64");
  CHECK(array.body->size() == 24 * numbers["points"].size());
  CHECK(tube.service.get(target + "&format=frame").status == 200);
  CHECK(tube.service.get(target + "&format=png&width=64&height=64").status == 200);
  tube.check_refused("/loop?at=v:30&normal=0,0,1&format=u16", 406, "not_acceptable", "format");
}

TEST_CASE("LoopsByGetAndPost") {
  TubeService tube;
  tube.check_same("/loop?at=v:30&normal=0.3,0.1,1&precision=7&hull=1",
                  R"({"at":"v:30","normal":[0.3,0.1,1],"precision":7,"hull":true})");
  tube.check_same("/loop?through=v:3&through=v:30&method=dijkstra",
                  R"({"through":[{"vertex":3},"v:30"],"method":"dijkstra"})");
}

TEST_CASE("WhatIsNoLoopSaysWhy") {
  TubeService tube;
  const auto check = [&](const std::string& base, const std::string& query,
                         const std::string& parameter, const std::string& words) {
    CAPTURE(query);
    const HttpResponse response = tube.service.get(base + query);
    check_problem(response, 422, "no_loop", parameter);
    CHECK(body_of(response)["detail"].get<std::string>().find(words) != std::string::npos);
  };
  const std::string plane = "/v1/meshes/" + tube.id;
  check(plane, "/loop?around=v:0&around=v:5&around=v:70", "around", "contracts to a point");
  check(plane, "/loop?through=v:3&through=v:3", "through", "at one place");
  check(plane, "/loop?at=v:30&normal=0,0,1", "normal", "only touches");
  check(tube.base, "/loop?at=v:28&normal=1,0,0", "normal", "boundary");
  check(tube.base, "/loop?at=v:28&normal=1,0,0&hull=1", "normal", "boundary");
  const std::string ball = tube.add(shapes::icosphere(2));
  check(ball, "/loop?at=v:30&normal=0.2,0.3,1", "at", "contracts to a point");
  const std::string two = tube.add(fixtures::two_components());
  check(two, "/loop?through=v:0&through=v:1&through=v:30", "through[1]", "no way leads");
}

// The points are at one place, on two sides of a face without area: the loop begins beside a vertex
// and ends at it.
TEST_CASE("ALoopPastAFaceWithoutAreaDoesNotSayHowItTurns") {
  PlaneService plane;
  const std::string flap =
      plane.add({{{-1, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 1, 0}}, {{2, 1, 0}, {0, 1, 3}}});
  const json methods = body_of(plane.service.get("/v1/methods"))["methods"];
  for (const json& method : methods) {
    for (const char* last : {"v:0", "v:1"}) {
      const HttpResponse response =
          plane.service.get(flap + "/loop?through=f:1,0.5,0.5&through=v:2&through=" + last +
                            "&method=" + method["name"].get<std::string>());
      REQUIRE(response.status == 200);
      const json loop = body_of(response);
      CHECK(loop["length"] == doctest::Approx(2));
      if (loop["turn"].is_null()) CHECK(loop["geodesic"] == false);
    }
  }
  // Over a side that such a face is on, back along the other sides.
  const std::string split = plane.add({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0, 0}, {1, 1, 0}},
                                       {{0, 1, 3}, {0, 1, 2}, {1, 4, 2}}});
  const HttpResponse response =
      plane.service.get(split + "/loop?around=v:0&around=v:1&around=v:2&around=v:3&method=exact");
  if (response.status == 200) {
    const json loop = body_of(response);
    CHECK(loop["geodesic"] == false);
    CHECK(loop["turn"].is_null());
    CHECK(loop["warnings"].size() == 1);
  } else {
    check_problem(response, 422, "no_loop", "around");
  }
}

TEST_CASE("LoopsThatAreRefused") {
  PlaneService plane;
  plane.check_refused("/loop", 400, "bad_syntax", "through");
  plane.check_refused("/loop?through=v:0&through=v:1&at=v:0", 400, "bad_syntax", "at");
  plane.check_refused("/loop?around=v:0&through=v:1", 400, "bad_syntax", "around");
  plane.check_refused("/loop?through=v:0", 422, "value_out_of_range", "through");
  plane.check_refused("/loop?around=v:0&around=v:1", 422, "value_out_of_range", "around");
  plane.check_refused("/loop?at=v:0", 400, "bad_syntax", "normal");
  plane.check_refused("/loop?at=v:0&normal=0,0,0", 422, "value_out_of_range", "normal");
  plane.check_refused("/loop?at=v:0&normal=1,2", 400, "bad_syntax", "normal");
  plane.check_refused("/loop?at=v:0&normal=0,0,1&hull=2", 400, "bad_syntax", "hull");
  plane.check_refused("/loop?at=v:0&normal=0,0,1&method=exact", 400, "unknown_parameter", "method");
  plane.check_refused("/loop?through=v:0&through=v:1&hull=1", 400, "unknown_parameter", "hull");
  plane.check_refused("/loop?around=v:0&around=v:1&around=v:2&normal=0,0,1", 400,
                      "unknown_parameter", "normal");
  plane.check_refused("/loop?through=v:0&through=v:120", 422, "index_out_of_range", "through[1]");
  plane.check_refused("/loop?through=v:0&through=v:1&method=magic", 422, "method_unknown",
                      "method");
  plane.check_refused("/loop?through=v:0&through=v:1&refine=none", 400, "unknown_parameter",
                      "refine");
  std::string many = "/loop?";
  for (int i = 0; i <= 100; ++i) many += "through=v:" + std::to_string(i % 2) + "&";
  many.pop_back();
  plane.check_refused(many, 413, "too_large", "through");
}
