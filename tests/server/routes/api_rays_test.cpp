#include <doctest/doctest.h>

#include <string>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("ARayIsEchoedAsItsFirstHit") {
  PlaneService plane;
  for (const char* ray : {"ray:2.5,3.25,7,0,0,-1", "ray:2.5,3.25,-7,0,0,0.01"}) {
    const json point = plane.ask(std::string("/nearest?point=") + ray)["points"][0];
    CHECK(point["xyz"] == json::parse("[2.5,3.25,0]"));
    CHECK(point["snap_distance"] == 0);
    CHECK(point["ray_distance"] == 7);
    CHECK_FALSE(point.contains("vertex"));
    const json same = plane.ask("/nearest?point=p:2.5,3.25,0")["points"][0];
    CHECK(point["face"] == same["face"]);
    CHECK(point["bary"] == same["bary"]);
    CHECK_FALSE(same.contains("ray_distance"));
  }
  const json vertex = plane.ask("/nearest?point=ray:3,2,5,0,0,-2")["points"][0];
  CHECK(vertex["vertex"] == 27);
  CHECK(vertex["ray_distance"] == 5);
}

TEST_CASE("ARayMayStandWhereverAPointMay") {
  PlaneService plane;
  const std::string at = "ray:2.5,3.25,7,0,0,-1";
  const std::string same = "p:2.5,3.25,0";
  const auto answers_alike = [&](const std::string& path, const std::string& before,
                                 const std::string& member) {
    CAPTURE(path);
    CHECK(plane.ask(path + before + at)[member] == plane.ask(path + before + same)[member]);
  };
  answers_alike("/distance", "?from=", "distances");
  answers_alike("/distance", "?from=v:0&at=v:3&at=", "distances");
  answers_alike("/path", "?to=v:9&from=", "length");
  answers_alike("/path", "?from=v:9&to=", "length");
  answers_alike("/path", "?from=v:9&to=v:0&via=", "length");
  answers_alike("/table", "?from=v:0&to=", "distances");
  answers_alike("/isolines", "?step=2&from=", "isolines");
  answers_alike("/samples", "?count=3&from=", "samples");
  answers_alike("/trace", "?direction=1,0,0&length=2&from=", "points");
}

TEST_CASE("ARayInJsonIsTheSameAsInAUrl") {
  PlaneService plane;
  plane.check_same("/path?from=ray:1.5,1.25,4,0,0,-1&to=v:9",
                   R"({"from":{"ray":{"origin":[1.5,1.25,4],"direction":[0,0,-1]}},"to":"v:9"})");
  const HttpResponse offset = plane.service.ask(
      "POST", plane.base + "/distance",
      R"({"from":[{"ray":{"origin":[3,2,4],"direction":[0,0,-1]},"offset":5}],"at":["v:27"]})");
  REQUIRE(offset.status == 200);
  CHECK(body_of(offset)["distances"][0] == 5);
}

TEST_CASE("ARayThatMissesIsNamed") {
  PlaneService plane;
  plane.check_refused("/distance?from=v:0&from=v:1&from=ray:2,2,5,0,0,1", 422, "no_hit", "from[2]");
  plane.check_refused("/nearest?point=ray:-1,2,5,0,0,-1", 422, "no_hit", "point[0]");
  plane.check_refused("/path?from=v:0&to=ray:2,2,5,1,0,0", 422, "no_hit", "to");
  plane.check_refused("/path?from=v:0&to=ray:2,2,5,0,0,0", 422, "value_out_of_range", "to");
  plane.check_refused("/path?from=v:0&to=ray:2,2,1e61,0,0,-1", 422, "value_out_of_range", "to");
  plane.check_refused("/path?from=v:0&to=ray:2,2,1e999,0,0,-1", 422, "value_out_of_range", "to");
  plane.check_refused("/path?from=v:0&to=ray:2,2", 400, "bad_syntax", "to");
  // From as far as coordinates go, it still meets.
  const json far = plane.ask("/nearest?point=ray:2.5,3.25,1e60,0,0,-1")["points"][0];
  CHECK(far["xyz"] == json::parse("[2.5,3.25,0]"));
  CHECK(far["ray_distance"] == 1e60);
}
