#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/vec2.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

// The plane has a vertex at each whole x below 12 and y below 10.
TEST_CASE("TheMapOfAPlaneIsThePlaneTurned") {
  PlaneService plane;
  const json reply = plane.ask("/logmap?from=v:53");  // (5, 4)
  CHECK(reply["mesh"] == plane.id);
  CHECK(reply["method"] == "auto");
  CHECK(reply["from"]["vertex"] == 53);
  CHECK(reply["angle"] == 0);
  CHECK(reply["total_angle"] == doctest::Approx(2 * std::numbers::pi));
  CHECK(reply["all_round"] == true);
  REQUIRE(reply["vertices"].size() == 120);
  CHECK(reply["radius"] == doctest::Approx(std::hypot(6, 5)));
  // By which angle, and whether seen from below, the first neighbour tells.
  const auto at = [&](int v) {
    return Vec2{reply["coordinates"][v][0].get<double>(), reply["coordinates"][v][1].get<double>()};
  };
  const Vec2 right = at(54);
  const Vec2 up = at(65);
  CHECK(norm(right) == doctest::Approx(1));
  CHECK(std::abs(dot(right, up)) < 1e-5);
  for (int v = 0; v < 120; ++v) {
    CHECK(reply["vertices"][v] == v);
    const Vec2 expected = (v % 12 - 5.0) * right + (v / 12 - 4.0) * up;
    CHECK(norm(at(v) - expected) < 1e-5);
    CHECK(reply["distances"][v] == doctest::Approx(norm(expected)));
  }
}

TEST_CASE("ATraceByAnAngleAndADistanceOfTheMapLeadsToItsVertex") {
  PlaneService plane;
  const std::string base = plane.add(shapes::terrain(12, 3, 5));
  for (const std::string from : {"v:70", "f:91,0.2,0.3", "f:91,0,0.3"}) {
    const json map = body_of(plane.service.get(base + "/logmap?from=" + from + "&method=exact"));
    int straight = 0;
    for (std::size_t i = 0; i < map["vertices"].size(); ++i) {
      if (map["straight"][i] == 0 || map["distances"][i] == 0) continue;
      ++straight;
      const json question{
          {"from", from}, {"angle", map["angles"][i]}, {"length", map["distances"][i]}};
      const json trace = body_of(plane.service.ask("POST", base + "/trace", question.dump()));
      const json there = body_of(plane.service.get(
          base + "/nearest?point=v:" + std::to_string(map["vertices"][i].get<int>())));
      CHECK(trace["end"] == "length");
      for (int k = 0; k < 3; ++k) {
        CHECK(trace["to"]["xyz"][k].get<double>() ==
              doctest::Approx(there["points"][0]["xyz"][k].get<double>()).epsilon(1e-6));
      }
    }
    CHECK(straight > 20);
  }
}

TEST_CASE("ARadiusAndAnAngleAreKept") {
  PlaneService plane;
  const json whole = plane.ask("/logmap?from=v:53&angle=0.5");
  const json near = plane.ask("/logmap?from=v:53&angle=0.5&radius=2");
  CHECK(near["radius"] == 2);
  CHECK(near["vertices"].size() == 13);
  std::size_t n = 0;
  for (std::size_t i = 0; i < whole["vertices"].size(); ++i) {
    if (whole["distances"][i] > 2) continue;
    CHECK(near["vertices"][n] == whole["vertices"][i]);
    CHECK(near["coordinates"][n] == whole["coordinates"][i]);
    const double angle = whole["angles"][i].get<double>() - 0.5;
    const double d = whole["distances"][i];
    CHECK(whole["coordinates"][i][0] == doctest::Approx(d * std::cos(angle)));
    CHECK(whole["coordinates"][i][1] == doctest::Approx(d * std::sin(angle)));
    ++n;
  }
  CHECK(n == 13);
}

TEST_CASE("AFrameOfTheMapHasTheNumbersOfItsJson") {
  PlaneService plane;
  const json text = plane.ask("/logmap?from=f:40,0.2,0.3&radius=3");
  const HttpResponse reply =
      plane.service.get(plane.base + "/logmap?from=f:40,0.2,0.3&radius=3&format=frame");
  REQUIRE(reply.status == 200);
  const std::string& bytes = *reply.body;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 8, sizeof length);
  const json about = json::parse(bytes.substr(24, length));
  CHECK(about["radius"] == 3);
  CHECK_FALSE(about.contains("distances"));
  std::vector<std::string> names;
  for (const json& array : about["arrays"]) names.push_back(array["name"]);
  CHECK(names ==
        std::vector<std::string>{"vertices", "distances", "angles", "straight", "coordinates"});
  CHECK(about["arrays"][4]["shape"] == json::array({text["vertices"].size(), 2}));
}

TEST_CASE("ADirectionThatIsCarriedOverAPlaneIsItsXAxis") {
  PlaneService plane;
  const json reply = plane.ask("/logmap?from=v:53&radius=3&angle=0.5&transport=1&method=exact");
  const auto at = [&](std::size_t i, const char* name, std::size_t k) {
    return reply[name][i][k].get<double>();
  };
  const std::size_t count = reply["vertices"].size();
  REQUIRE(reply["directions"].size() == count);
  for (std::size_t i = 0; i < count; ++i) {
    // By how far along it a vertex lies from the point.
    const int v = reply["vertices"][i];
    const double along =
        (v % 12 - 5.0) * at(i, "directions", 0) + (v / 12 - 4.0) * at(i, "directions", 1);
    CHECK(along == doctest::Approx(at(i, "coordinates", 0)));
    CHECK(at(i, "directions", 2) == 0);
    CHECK(std::hypot(at(i, "directions", 0), at(i, "directions", 1)) == doctest::Approx(1));
  }
  CHECK_FALSE(plane.ask("/logmap?from=v:53&radius=3").contains("directions"));
  const HttpResponse frame =
      plane.service.get(plane.base + "/logmap?from=v:53&radius=3&transport=1&format=frame");
  REQUIRE(frame.status == 200);
  std::uint32_t length = 0;
  std::memcpy(&length, frame.body->data() + 8, sizeof length);
  const json about = json::parse(frame.body->substr(24, length));
  CHECK(about["arrays"][5]["name"] == "directions");
  CHECK(about["arrays"][5]["shape"] == json::array({count, 3}));
  CHECK_FALSE(about.contains("directions"));
  const HttpResponse glb =
      plane.service.get(plane.base + "/logmap?from=v:53&radius=3&transport=1&format=glb");
  REQUIRE(glb.status == 200);
  std::memcpy(&length, glb.body->data() + 12, sizeof length);
  const json gltf = json::parse(glb.body->substr(20, length));
  const json& attributes = gltf["meshes"][0]["primitives"][0]["attributes"];
  const json& accessor = gltf["accessors"][attributes["_GEODESIC_DIRECTION"].get<int>()];
  CHECK(accessor["count"] == count);
  CHECK(accessor["type"] == "VEC3");
}

TEST_CASE("AsGlbTheMapIsTextureCoordinatesOfTheFacesWithin") {
  PlaneService plane;
  const HttpResponse reply =
      plane.service.get(plane.base + "/logmap?from=v:53&radius=2&format=glb");
  REQUIRE(reply.status == 200);
  const std::string& bytes = *reply.body;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, sizeof length);
  const json gltf = json::parse(bytes.substr(20, length));
  const json& primitive = gltf["meshes"][0]["primitives"][0];
  const json& uv = gltf["accessors"][primitive["attributes"]["TEXCOORD_0"].get<int>()];
  CHECK(gltf["materials"][primitive["material"].get<int>()]["name"] == "textured");
  CHECK(uv["count"] == 13);
  CHECK(uv["type"] == "VEC2");
  const json& view = gltf["bufferViews"][uv["bufferView"].get<int>()];
  const char* data = bytes.data() + 20 + length + 8 + view["byteOffset"].get<int>();
  for (int i = 0; i < 26; ++i) {
    float value = 0;
    std::memcpy(&value, data + 4 * i, 4);
    CHECK(value >= 0);
    CHECK(value <= 1);
  }
  // The four squares about the point, and some of the faces beside them.
  const int corners = gltf["accessors"][primitive["indices"].get<int>()]["count"];
  CHECK(corners % 3 == 0);
  CHECK(corners >= 3 * 8);
  CHECK(corners <= 3 * 16);
}

TEST_CASE("WhatTheMapRefuses") {
  PlaneService plane;
  plane.check_refused("/logmap", 400, "bad_syntax", "from");
  plane.check_refused("/logmap?from=v:0&radius=0", 422, "value_out_of_range", "radius");
  plane.check_refused("/logmap?from=v:0&radius=-1", 422, "value_out_of_range", "radius");
  plane.check_refused("/logmap?from=v:0&angle=x", 400, "bad_syntax", "angle");
  plane.check_refused("/logmap?from=v:0&transport=x", 400, "bad_syntax", "transport");
  plane.check_same("/logmap?from=v:0&radius=3&transport=1",
                   R"({"from":"v:0","radius":3,"transport":true})");
  plane.check_refused("/logmap?from=v:999", 422, "index_out_of_range", "from");
  plane.check_refused("/logmap?from=v:0&max=2", 400, "unknown_parameter", "max");
  plane.check_same("/logmap?from=v:0&radius=3&angle=0.25",
                   R"({"from":"v:0","radius":3,"angle":0.25})");
  // Two faces that meet in a vertex alone.
  TriangleSoup bow;
  bow.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  bow.faces = {{0, 1, 2}, {0, 3, 4}};
  check_problem(plane.service.get(plane.add(bow) + "/logmap?from=v:0"), 422, "value_out_of_range",
                "from");
}
