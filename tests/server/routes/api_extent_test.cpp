#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

// The plane has a vertex at each whole x below 12 and y below 10.
TEST_CASE("TheExtentsOfAPlane") {
  PlaneService plane;
  const json diameter = plane.ask("/extent?of=diameter&method=exact");
  CHECK(diameter["mesh"] == plane.id);
  CHECK(diameter["method"] == "exact");
  CHECK(diameter["of"] == "diameter");
  CHECK(diameter["value"] == doctest::Approx(std::hypot(11, 9)));
  CHECK(diameter["exact"] == true);
  CHECK(diameter["lower"] == diameter["value"]);
  CHECK(diameter["upper"] == diameter["value"]);
  CHECK(diameter["confidence"] == 1);
  CHECK(diameter["part_vertices"] == 120);
  CHECK(diameter["fields"].get<int>() < 100);
  REQUIRE(diameter["vertices"].size() == 2);
  const int one = diameter["vertices"][0]["vertex"];
  const int other = diameter["vertices"][1]["vertex"];
  CHECK((one + other == 119));  // two corners across
  const json center = plane.ask("/extent?of=center&method=exact&fields=120");
  CHECK(center["exact"] == true);
  CHECK(center["value"] == doctest::Approx(std::hypot(6, 5)));
  CHECK(center["vertices"].size() == 1);
  CHECK(center["vertices"][0]["xyz"][2] == 0);
  const json median = plane.ask("/extent?of=median&method=exact&fields=120");
  const std::string vertex = std::to_string(median["vertices"][0]["vertex"].get<int>());
  const json about = plane.ask("/measure?method=exact&from=v:" + vertex);
  CHECK(median["value"].get<double>() == doctest::Approx(about["mean"].get<double>()));
}

TEST_CASE("AMeanIsEstimatedWithAnInterval") {
  PlaneService plane;
  const json whole = plane.ask("/extent?of=mean&method=exact&fields=1000");
  CHECK(whole["exact"] == true);
  CHECK(whole["fields"] == 120);
  CHECK(whole["confidence"] == 1);
  CHECK(whole["vertices"].empty());
  const json some = plane.ask("/extent?of=mean&method=exact&fields=30");
  CHECK(some["exact"] == false);
  CHECK(some["confidence"] == 0.95);
  CHECK(some["lower"] < some["value"]);
  CHECK(some["value"] < some["upper"]);
  CHECK(some["value"].get<double>() == doctest::Approx(whole["value"].get<double>()).epsilon(0.2));
  CHECK(plane.ask("/extent?of=mean&fields=1")["upper"].is_null());
}

TEST_CASE("ExtentsByGetAndPost") {
  PlaneService plane;
  plane.check_same("/extent?of=center&fields=7&method=dijkstra&precision=7",
                   R"({"of":"center","fields":7,"method":"dijkstra","precision":7})");
}

TEST_CASE("ExtentsThatAreRefused") {
  PlaneService plane;
  plane.check_refused("/extent", 400, "bad_syntax", "of");
  plane.check_refused("/extent?of=girth", 400, "bad_syntax", "of");
  plane.check_refused("/extent?of=center&fields=0", 422, "value_out_of_range", "fields");
  plane.check_refused("/extent?of=center&fields=x", 400, "bad_syntax", "fields");
  plane.check_refused("/extent?of=center&fields=1001", 413, "too_large", "fields");
  plane.check_refused("/extent?of=center&from=v:0", 400, "unknown_parameter", "from");
  plane.check_refused("/extent?of=center&method=magic", 422, "method_unknown", "method");
  plane.check_refused("/extent?of=center&format=glb", 406, "not_acceptable", "format");
}
