#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <string>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using std::numbers::pi;

namespace {

json gltf_of(const HttpResponse& reply) {
  REQUIRE(reply.status == 200);
  REQUIRE(reply.content_type == "model/gltf-binary");
  std::uint32_t length = 0;
  std::memcpy(&length, reply.body->data() + 12, sizeof length);
  return json::parse(reply.body->substr(20, length));
}

}  // namespace

// The plane has a vertex at each whole x below 12 and y below 10.
TEST_CASE("DiscsInThePlaneAreCircles") {
  PlaneService plane;
  const json reply = plane.ask("/measure?from=v:53&radii=3.5&radii=2.5&radii=99");  // (5, 4)
  CHECK(reply["mesh"] == plane.id);
  CHECK(reply["method"] == "auto");
  CHECK(reply["from"][0]["vertex"] == 53);
  CHECK(reply["area"] == doctest::Approx(99));
  CHECK(reply["max"] == doctest::Approx(std::hypot(6, 5)));
  CHECK(reply["farthest"] == 119);
  CHECK(reply["mean"] > 3);
  CHECK(reply["mean"] < 4);
  REQUIRE(reply["discs"].size() == 3);
  for (int i = 0; i < 2; ++i) {
    const json& disc = reply["discs"][i];
    const double r = 2.5 + i;
    CHECK(disc["radius"] == r);
    CHECK(disc["area"] == doctest::Approx(pi * r * r).epsilon(0.06));
    CHECK(disc["perimeter"] == doctest::Approx(2 * pi * r).epsilon(0.06));
    CHECK(disc["mean"] == doctest::Approx(2 * r / 3).epsilon(0.06));
    CHECK(disc["boundary"] == 0);
    CHECK(disc["lines"] == 1);
    CHECK(disc["euler"] == 1);
    CHECK(disc["whole"] == false);
  }
  CHECK(reply["discs"][0]["vertices"] == 21);
  const json& all = reply["discs"][2];
  CHECK(all["radius"] == 99);
  CHECK(all["area"] == reply["area"]);
  CHECK(all["mean"] == reply["mean"]);
  CHECK(all["perimeter"] == 0);
  CHECK(all["boundary"] == doctest::Approx(40));
  CHECK(all["lines"] == 0);
  CHECK(all["vertices"] == 120);
  CHECK(all["whole"] == true);
}

TEST_CASE("PerimetersAreTheLengthsOfTheIsolines") {
  PlaneService plane;
  const std::string base = plane.add(shapes::terrain(30, 4, 2));
  for (const std::string by : {"", "&method=dijkstra", "&max=12"}) {
    const std::string from = "from=v:7&from=f:90,0.2,0.3" + by;
    const json reply =
        body_of(plane.service.get(base + "/measure?" + from + "&radii=3&radii=7.5&radii=12"));
    const json lines =
        body_of(plane.service.get(base + "/isolines?" + from + "&levels=3&levels=7.5&levels=12"));
    for (const json& disc : reply["discs"]) {
      double length = 0;
      int count = 0;
      for (const json& line : lines["isolines"]) {
        if (line["level"] != disc["radius"]) continue;
        length += line["length"].get<double>();
        ++count;
      }
      CHECK(count > 0);
      CHECK(disc["lines"] == count);
      CHECK(disc["perimeter"] == doctest::Approx(length).epsilon(1e-12));
    }
  }
}

TEST_CASE("AMaximumEndsWhatIsMeasured") {
  PlaneService plane;
  const json whole = plane.ask("/measure?from=v:0&radii=4.5&radii=2");
  const json near = plane.ask("/measure?from=v:0&radii=4.5&radii=2&max=4.5");
  CHECK(near["discs"] == whole["discs"]);
  CHECK(near["area"] == near["discs"][1]["area"]);
  CHECK(near["mean"] == near["discs"][1]["mean"]);
  CHECK(near["max"] == doctest::Approx(std::hypot(4, 2)));
  CHECK(near["farthest"] == 28);  // (4, 2), which has the lower number than (2, 4)
}

TEST_CASE("CopiesOfAVertexCountAsTheClientsVertices") {
  PlaneService plane;
  TriangleSoup soup = shapes::plane(5, 5);
  TriangleSoup split;
  for (const auto& face : soup.faces) {
    const auto first = static_cast<std::uint32_t>(split.positions.size());
    for (const std::uint32_t v : face) split.positions.push_back(soup.positions[v]);
    split.faces.push_back({first, first + 1, first + 2});
  }
  const json reply =
      body_of(plane.service.get(plane.add(split) + "/measure?from=p:2,2,0&radii=0&radii=100"));
  CHECK(reply["discs"][0]["vertices"] == 6);
  CHECK(reply["discs"][0]["area"] == 0);
  CHECK(reply["discs"][0]["euler"] == 1);
  CHECK(reply["discs"][1]["vertices"] == 96);
  CHECK(reply["discs"][1]["euler"] == 1);
}

TEST_CASE("WhatNoSourceReachesIsNotMeasured") {
  PlaneService plane;
  const json reply = body_of(
      plane.service.get(plane.add(fixtures::two_components()) + "/measure?from=v:0&radii=50"));
  CHECK(reply["area"] == doctest::Approx(16));
  CHECK(reply["discs"][0]["area"] == reply["area"]);
  CHECK(reply["discs"][0]["whole"] == false);
}

TEST_CASE("AsGlbTheStripsBetweenTheRadiiAddUpToTheSurface") {
  PlaneService plane;
  const std::string target = "/measure?from=v:53&radii=2&radii=3.5";
  const json gltf = gltf_of(plane.service.get(plane.base + target + "&format=glb"));
  const json numbers = plane.ask(target);
  REQUIRE(gltf["nodes"].size() == 3);
  CHECK(gltf["nodes"][0]["name"] == "strip 0 to 2");
  CHECK(gltf["nodes"][1]["name"] == "strip 2 to 3.5");
  CHECK(gltf["nodes"][2]["extras"]["from"] == 3.5);
  CHECK(gltf["nodes"][2]["extras"]["to"] == numbers["max"]);
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    sum += gltf["nodes"][i]["extras"]["area"].get<double>();
    if (i < 2) {
      CHECK(sum == doctest::Approx(numbers["discs"][i]["area"].get<double>()).epsilon(1e-12));
    }
    CHECK(gltf["meshes"][gltf["nodes"][i]["mesh"].get<int>()]["primitives"][0].contains("indices"));
  }
  CHECK(sum == doctest::Approx(99).epsilon(1e-12));
  // Without a radius, or beyond the surface, it is all one strip.
  CHECK(gltf_of(plane.service.get(plane.base + "/measure?from=v:53&format=glb"))["nodes"].size() ==
        1);
  CHECK(gltf_of(plane.service.get(plane.base + "/measure?from=v:53&radii=50&format=glb"))["nodes"]
            .size() == 1);
}

TEST_CASE("MeasuresByGetAndPost") {
  PlaneService plane;
  plane.check_same(
      "/measure?from=v:7&radii=2&radii=3&method=dijkstra&precision=7&max=5",
      R"({"from":{"vertex":7},"radii":[2,3],"method":"dijkstra","precision":7,"max":5})");
  plane.check_same("/measure?from=v:7", R"({"from":"v:7"})");
}

TEST_CASE("MeasuresThatAreRefused") {
  PlaneService plane;
  plane.check_refused("/measure", 400, "bad_syntax", "from");
  plane.check_refused("/measure?from=v:0&radii=x", 400, "bad_syntax", "radii[0]");
  plane.check_refused("/measure?from=v:0&radii=1&radii=-1", 422, "value_out_of_range", "radii[1]");
  plane.check_refused("/measure?from=v:0&radii=3&max=2", 422, "value_out_of_range", "radii[0]");
  plane.check_refused("/measure?from=v:120&radii=1", 422, "index_out_of_range", "from[0]");
  plane.check_refused("/measure?from=v:0&radii=1&method=magic", 422, "method_unknown", "method");
  plane.check_refused("/measure?from=v:0&radii=1&format=csv", 406, "not_acceptable", "format");
  plane.check_refused("/measure?from=v:0&radius=1", 400, "unknown_parameter", "radius");
  std::string many = "/measure?from=v:0";
  for (int i = 0; i <= 1000; ++i) many += "&radii=1";
  plane.check_refused(many, 413, "too_large", "radii");
}

TEST_CASE("StripsThatAreCutTooOftenAreRefused") {
  PlaneService plane;
  const std::string base = plane.add(shapes::plane(601, 601));
  json question{{"from", "v:180600"}, {"format", "glb"}, {"radii", json::array()}};
  for (int i = 1; i <= 1000; ++i) question["radii"].push_back(0.3 * i);
  check_problem(plane.service.ask("POST", base + "/measure", question.dump()), 413, "too_large",
                "radii");
  question["format"] = "json";
  const json reply = body_of(plane.service.ask("POST", base + "/measure", question.dump()));
  CHECK(reply["discs"].size() == 1000);
  CHECK(reply["discs"][999]["area"].get<double>() <= 600.0 * 600 * (1 + 1e-12));
}
