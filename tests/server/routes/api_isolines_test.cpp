#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

constexpr double kPi = 3.14159265358979323846;

}  // namespace

TEST_CASE("IsolinesFromACornerAreQuarterCircles") {
  PlaneService plane;
  const json reply = plane.ask("/isolines?from=v:0&levels=6&levels=3&levels=4.5");
  CHECK(reply["mesh"] == plane.id);
  CHECK(reply["method"] == "auto");
  CHECK(reply["from"][0]["vertex"] == 0);
  CHECK(reply["max"] == doctest::Approx(std::hypot(11, 9)));
  CHECK(reply["levels"] == json::parse("[3,4.5,6]"));
  REQUIRE(reply["isolines"].size() == 3);
  for (int i = 0; i < 3; ++i) {
    const json& line = reply["isolines"][i];
    const double level = reply["levels"][i];
    CHECK(line["level"] == level);
    CHECK(line["closed"] == false);
    CHECK(line["length"] == doctest::Approx(kPi / 2 * level).epsilon(0.02));
    CHECK(length_of(line["points"]) == doctest::Approx(line["length"].get<double>()));
    for (const json& p : line["points"]) {
      CHECK(std::hypot(p[0].get<double>(), p[1].get<double>()) ==
            doctest::Approx(level).epsilon(0.03));
      CHECK(p[2] == 0);
    }
  }
}

TEST_CASE("AClosedIsolineHasItsFirstPointOnceAndItsLastSegmentInItsLength") {
  PlaneService plane;
  const json reply = plane.ask("/isolines?from=v:53&levels=3");  // (5, 4)
  REQUIRE(reply["isolines"].size() == 1);
  const json& line = reply["isolines"][0];
  CHECK(line["closed"] == true);
  CHECK(line["length"] == doctest::Approx(2 * kPi * 3).epsilon(0.02));
  json points = line["points"];
  CHECK(points.front() != points.back());
  points.push_back(points.front());
  CHECK(length_of(points) == doctest::Approx(line["length"].get<double>()).epsilon(1e-12));
}

TEST_CASE("LevelsByStepAndByCount") {
  PlaneService plane;
  CHECK(plane.ask("/isolines?from=v:0&step=2.5")["levels"] == json::parse("[2.5,5,7.5,10,12.5]"));
  CHECK(plane.ask("/isolines?from=v:0&step=2.5&max=7.5")["levels"] == json::parse("[2.5,5,7.5]"));
  CHECK(plane.ask("/isolines?from=v:0&count=3&max=8")["levels"] == json::parse("[2,4,6]"));
  const json even = plane.ask("/isolines?from=v:0&count=4");
  const double most = std::hypot(11, 9);
  REQUIRE(even["levels"].size() == 4);
  for (int i = 0; i < 4; ++i) CHECK(even["levels"][i] == doctest::Approx(most * (i + 1) / 5));
  CHECK(even["isolines"].size() >= 4);
  // Beyond the greatest distance there is no line, and beyond `max` none is drawn.
  CHECK(plane.ask("/isolines?from=v:0&levels=3&levels=9&levels=99&max=8")["levels"] ==
        json::parse("[3]"));
  CHECK(plane.ask("/isolines?from=v:0&levels=99")["isolines"].empty());
  CHECK(plane.ask("/isolines?from=v:0&levels=0&levels=0")["isolines"].empty());
}

TEST_CASE("MaxLeavesNoGapsInTheLinesWithinIt") {
  PlaneService plane;
  const json whole = plane.ask("/isolines?from=v:53&levels=2&levels=3.99");
  const json bounded = plane.ask("/isolines?from=v:53&levels=2&levels=3.99&max=4");
  CHECK(bounded["max"] == 4);
  CHECK(whole["isolines"] == bounded["isolines"]);
}

TEST_CASE("IsolinesOfSeveralSourcesAndComponents") {
  PlaneService plane;
  const std::string base = plane.add(fixtures::two_components());
  const json one = body_of(plane.service.get(base + "/isolines?from=v:0&levels=2"));
  REQUIRE(one["isolines"].size() == 1);
  const json both = body_of(plane.service.get(base + "/isolines?from=v:0&from=v:25&levels=2"));
  REQUIRE(both["isolines"].size() == 2);
  CHECK(both["isolines"][0]["length"].get<double>() ==
        doctest::Approx(both["isolines"][1]["length"].get<double>()));
  // A source with an offset: its circle is smaller.
  const json offset = body_of(plane.service.ask(
      "POST", base + "/isolines", R"({"from":[{"vertex":0,"offset":0.5}],"levels":2.5})"));
  CHECK(offset["isolines"][0]["points"].size() == one["isolines"][0]["points"].size());
}

TEST_CASE("IsolinesFromAVertexInNoFaceAreNone") {
  PlaneService plane;
  TriangleSoup soup = shapes::plane(3, 3);
  soup.positions.push_back({9, 9, 9});
  const std::string base = plane.add(soup);
  const json reply = body_of(plane.service.get(base + "/isolines?from=v:9&count=5"));
  CHECK(reply["max"] == 0);
  CHECK(reply["levels"].empty());
  CHECK(reply["isolines"].empty());
}

TEST_CASE("IsolinesByGetAndPost") {
  PlaneService plane;
  plane.check_same("/isolines?from=v:3&levels=1&levels=2.5&method=dijkstra",
                   R"({"from":"v:3","levels":[1,2.5],"method":"dijkstra"})");
  plane.check_same("/isolines?from=v:3&step=1.5&max=9&precision=6",
                   R"({"from":["v:3"],"step":1.5,"max":9,"precision":6})");
  plane.check_same("/isolines?from=v:3&count=7", R"({"from":["v:3"],"count":7,"levels":[]})");
}

TEST_CASE("IsolinesThatAreRefused") {
  PlaneService plane;
  plane.check_refused("/isolines?levels=1", 400, "bad_syntax", "from");
  plane.check_refused("/isolines?from=v:0", 400, "bad_syntax", "levels");
  plane.check_refused("/isolines?from=v:0&levels=1&step=1", 400, "bad_syntax", "step");
  plane.check_refused("/isolines?from=v:0&levels=1&count=1", 400, "bad_syntax", "count");
  plane.check_refused("/isolines?from=v:0&step=1&count=1", 400, "bad_syntax", "count");
  plane.check_refused("/isolines?from=v:0&levels=1&levels=x", 400, "bad_syntax", "levels[1]");
  plane.check_refused("/isolines?from=v:0&levels=1&levels=-1", 422, "value_out_of_range",
                      "levels[1]");
  plane.check_refused("/isolines?from=v:0&step=0", 422, "value_out_of_range", "step");
  plane.check_refused("/isolines?from=v:0&step=-2", 422, "value_out_of_range", "step");
  plane.check_refused("/isolines?from=v:0&step=wide", 400, "bad_syntax", "step");
  plane.check_refused("/isolines?from=v:0&count=0", 422, "value_out_of_range", "count");
  plane.check_refused("/isolines?from=v:0&count=2.5", 400, "bad_syntax", "count");
  plane.check_refused("/isolines?from=v:0&count=10001", 413, "too_large", "count");
  plane.check_refused("/isolines?from=v:0&step=0.001", 413, "too_large", "step");
  plane.check_refused("/isolines?from=v:0&step=1e-300", 413, "too_large", "step");
  plane.check_refused("/isolines?from=v:0&count=5&format=f32", 406, "not_acceptable", "format");
  plane.check_refused("/isolines?from=v:120&count=5", 422, "index_out_of_range", "from[0]");
  plane.check_refused("/isolines?from=v:0&count=5&to=v:1", 400, "unknown_parameter", "to");
  check_problem(plane.service.ask("POST", plane.base + "/isolines",
                                  json{{"from", "v:0"}, {"levels", json(10'001, 1.0)}}.dump()),
                413, "too_large", "levels");
}

TEST_CASE("IsolinesOfTooManySegmentsAreRefused") {
  PlaneService plane;
  // 80,000 faces, each crossed by some 35 of 10,000 levels.
  const std::string base = plane.add(shapes::plane(201, 201));
  const HttpResponse response = plane.service.get(base + "/isolines?from=v:0&count=10000");
  check_problem(response, 413, "too_large", "count");
  const json problem = body_of(response);
  CHECK(problem["limit"] == 1'000'000);
  CHECK(problem["actual"] > 1'000'000);
}
