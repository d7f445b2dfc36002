// Paths through points, and paths made shortest.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/server/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

bool passes(const json& points, Vec3 place) {
  return std::any_of(points.begin(), points.end(), [&](const json& point) {
    const json& p = point["xyz"];
    return distance(Vec3{p[0].get<double>(), p[1].get<double>(), p[2].get<double>()}, place) <
           1e-12;
  });
}

}  // namespace

TEST_CASE("PathThroughPointsVisitsThemInOrder") {
  PlaneService plane;
  const json reply = plane.ask("/path?from=v:0&via=v:11&via=p:6.25,4.5,0&to=v:119");
  CHECK(reply["reachable"] == true);
  REQUIRE(reply["via"].size() == 2);
  CHECK(reply["via"][0]["vertex"] == 11);
  const double expected = 11 + std::hypot(11 - 6.25, 4.5) + std::hypot(11 - 6.25, 9 - 4.5);
  CHECK(reply["length"] == doctest::Approx(expected));
  CHECK(length_of(reply["points"]) == doctest::Approx(expected));
  CHECK(passes(reply["points"], {11, 0, 0}));
  CHECK(passes(reply["points"], {6.25, 4.5, 0}));
  for (std::size_t i = 1; i < reply["points"].size(); ++i) {
    CHECK(reply["points"][i]["xyz"] != reply["points"][i - 1]["xyz"]);
  }
  CHECK(plane.ask("/path?from=v:0&to=v:119")["via"].empty());
}

TEST_CASE("PathThroughItsOwnEndsIsThePath") {
  PlaneService plane;
  const json straight = plane.ask("/path?from=v:3&to=v:99");
  const json through = plane.ask("/path?from=v:3&via=v:3&via=v:99&to=v:99");
  CHECK(through["length"] == straight["length"]);
  CHECK(through["points"].size() == straight["points"].size());
  const json nowhere = plane.ask("/path?from=v:3&via=v:3&to=v:3&refine=shortest");
  CHECK(nowhere["reachable"] == true);
  CHECK(nowhere["length"] == 0);
  CHECK(nowhere["points"].size() == 1);
}

TEST_CASE("PathThroughAnotherComponentIsNotReachable") {
  PlaneService plane;
  const std::string base = plane.add(fixtures::two_components());
  for (const std::string refine : {"none", "shortest"}) {
    const json reply =
        body_of(plane.service.get(base + "/path?from=v:0&via=v:30&to=v:24&refine=" + refine));
    CHECK(reply["reachable"] == false);
    CHECK(reply["length"].is_null());
    CHECK(reply["points"].empty());
    CHECK(reply["via"][0]["vertex"] == 30);
    CHECK(reply["refine"] == refine);
  }
}

TEST_CASE("ARefinedPathIsNeverLongerByAnyMethod") {
  PlaneService plane;
  const json methods = body_of(plane.service.get("/v1/methods"))["methods"];
  const std::vector<std::string> bases{plane.base, plane.add(shapes::terrain(24, 5, 7)),
                                       plane.add(shapes::torus_knot(60, 8, 0.4))};
  for (const std::string& base : bases) {
    for (const json& method : methods) {
      const std::string by = "&method=" + method["name"].get<std::string>();
      for (const std::string ends :
           {"from=v:0&to=v:99", "from=v:17&to=f:80,0.3,0.3", "from=f:11,0.1,0.2&via=v:60&to=v:5"}) {
        CAPTURE(by);
        CAPTURE(ends);
        const json plain = body_of(plane.service.get(base + "/path?" + ends + by));
        const json refined =
            body_of(plane.service.get(base + "/path?" + ends + by + "&refine=shortest"));
        CHECK(plain["refine"] == "none");
        CHECK(refined["refine"] == "shortest");
        CHECK(refined["length"].get<double>() <= plain["length"].get<double>());
        CHECK(length_of(refined["points"]) ==
              doctest::Approx(refined["length"].get<double>()).epsilon(1e-9));
        CHECK(refined["points"].front()["xyz"] == plain["points"].front()["xyz"]);
        CHECK(refined["points"].back()["xyz"] == plain["points"].back()["xyz"]);
      }
    }
  }
}

TEST_CASE("RefiningAnEdgePathOnAPlaneMakesItStraight") {
  PlaneService plane;
  const std::string query = "/path?from=v:0&to=v:95&method=dijkstra";  // (11, 7)
  CHECK(plane.ask(query)["length"] == doctest::Approx(4 + 7 * std::sqrt(2.0)));
  const json straight = plane.ask(query + "&refine=shortest");
  CHECK(straight["length"] == doctest::Approx(std::hypot(11, 7)));
  // Joints stay where they are: each leg is straight, the whole is not.
  const json bent = plane.ask(query + "&refine=shortest&via=v:84");  // (0, 7)
  CHECK(bent["length"] == doctest::Approx(18));
  CHECK(passes(bent["points"], {0, 7, 0}));
}

TEST_CASE("PathsByGetAndPost") {
  PlaneService plane;
  plane.check_same("/path?from=v:0&via=v:40&via=p:2,3,1&to=v:119&refine=shortest",
                   R"({"from":"v:0","via":["v:40",{"xyz":[2,3,1]}],"to":"v:119",)"
                   R"("refine":"shortest"})");
  plane.check_same("/path?from=v:0&via=v:40&to=v:1&method=dijkstra",
                   R"({"from":"v:0","via":{"vertex":40},"to":"v:1","method":"dijkstra"})");
}

TEST_CASE("PathsThatAreRefused") {
  PlaneService plane;
  plane.check_refused("/path?from=v:0&to=v:1&refine=flip", 422, "value_out_of_range", "refine");
  plane.check_refused("/path?from=v:0&to=v:1&via=w:1", 400, "bad_syntax", "via[0]");
  plane.check_refused("/path?from=v:0&to=v:1&via=v:2&via=v:999", 422, "index_out_of_range",
                      "via[1]");
  plane.check_refused("/path?from=v:0&to=v:1&max=3", 400, "unknown_parameter", "max");
  plane.check_refused("/path?from=v:0&to=v:1&format=csv", 406, "not_acceptable", "format");
  check_problem(
      plane.service.ask("POST", plane.base + "/path",
                        json{{"from", "v:0"}, {"to", "v:1"}, {"via", json(101, "v:2")}}.dump()),
      413, "too_large", "via");
  check_problem(plane.service.ask("POST", plane.base + "/path",
                                  R"({"from":"v:0","to":"v:1","via":{"vertex":2,"offset":1}})"),
                422, "value_out_of_range", "via[0].offset");
}

TEST_CASE("PathThroughPointsUsesFieldsThatAreThere") {
  PlaneService plane;
  const std::string query = "/path?from=v:0&via=v:50&to=v:100";
  CHECK(header_of(plane.service.get(plane.base + query), "Geo-Cache") == "miss");
  CHECK(header_of(plane.service.get(plane.base + query + "&refine=shortest"), "Geo-Cache") ==
        "hit");
  const HttpResponse f64 = plane.service.get(plane.base + query + "&format=f64");
  CHECK(std::stod(header_of(f64, "Geo-Length")) == plane.ask(query)["length"].get<double>());
}
