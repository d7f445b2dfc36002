#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
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

TEST_CASE("TheMeanDistanceOfEachVertexOfAPlane") {
  PlaneService plane;
  const json whole = plane.ask("/extent?of=means&method=exact&fields=1000");
  CHECK(whole["exact"] == true);
  CHECK(whole["confidence"] == 1);
  CHECK(whole["fields"] == 120);
  CHECK(whole["vertices"].empty());
  REQUIRE(whole["means"].size() == 120);
  REQUIRE(whole["margins"].size() == 120);
  const json mean = plane.ask("/extent?of=mean&method=exact&fields=1000");
  CHECK(whole["value"] == mean["value"]);
  for (const int v : {0, 7, 65, 119}) {
    const json about = plane.ask("/measure?method=exact&from=v:" + std::to_string(v));
    CHECK(whole["means"][v].get<double>() == doctest::Approx(about["mean"].get<double>()));
    CHECK(whole["margins"][v] == 0);
  }
  const json some = plane.ask("/extent?of=means&method=exact&fields=15");
  CHECK(some["exact"] == false);
  CHECK(some["confidence"] == 0.95);
  CHECK(some["value"] == plane.ask("/extent?of=mean&method=exact&fields=15")["value"]);
  CHECK(some["margins"][0] > 0);
  CHECK(plane.ask("/extent?of=means&fields=1")["margins"][0].is_null());
}

// Copies of a vertex have its mean, and one in no face has none.
TEST_CASE("MeansAreBySourceVertexInEveryFormat") {
  PlaneService plane;
  const std::string base = plane.add(
      {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {9, 9, 9}, {1, 0, 0}, {1, 1, 0}}, {{0, 1, 2}, {4, 5, 2}}});
  const json means = body_of(plane.service.get(base + "/extent?of=means&method=exact"))["means"];
  REQUIRE(means.size() == 6);
  CHECK(means[3].is_null());
  CHECK(means[1] == means[4]);
  CHECK(means[0] == means[5]);
  const HttpResponse bare = plane.service.get(base + "/extent?of=means&method=exact&format=f64");
  REQUIRE(bare.status == 200);
  CHECK(header_of(bare, "Geo-Shape") == "6");
  REQUIRE(bare.body->size() == 48);
  std::array<double, 6> values{};
  std::memcpy(values.data(), bare.body->data(), 48);
  CHECK(std::isinf(values[3]));
  for (const int v : {0, 1, 2, 4, 5}) CHECK(values[v] == means[v].get<double>());
  for (const char* format : {"f32", "npy", "frame", "glb", "png&width=64&height=64", "annotated"}) {
    CAPTURE(format);
    const HttpResponse reply = plane.service.get(base + "/extent?of=means&format=" + format);
    CHECK(reply.status == 200);
    CHECK(reply.body->size() > 20);
  }
  const HttpResponse named =
      plane.service.get(base + "/extent?of=means&format=annotated&attribute=_MIDDLE");
  CHECK(named.body->find("\"_MIDDLE\"") != std::string::npos);
  const HttpResponse file = plane.service.get(base + "/extent?of=means&format=annotated");
  CHECK(file.body->find("\"_GEODESIC_MEAN_DISTANCE\"") != std::string::npos);
}

TEST_CASE("ExtentsByGetAndPost") {
  PlaneService plane;
  plane.check_same("/extent?of=means&fields=7&method=dijkstra&precision=7",
                   R"({"of":"means","fields":7,"method":"dijkstra","precision":7})");
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
