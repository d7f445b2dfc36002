// Points in space that the surface is far from: answered, with a warning.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// 5 % of the diagonal of the plane's box, 11 by 9.
const double kLimit = 0.05 * std::hypot(11.0, 9.0);

std::string above(double x, double y, double z) {
  char text[100];
  std::snprintf(text, sizeof(text), "p:%.17g,%.17g,%.17g", x, y, z);
  return text;
}

std::vector<std::string> warnings_of(const json& reply) {
  return reply.value("warnings", std::vector<std::string>());
}

}  // namespace

TEST_CASE("PointsFarFromTheSurfaceAreWarnedOfInEveryQuery") {
  PlaneService plane;
  std::mt19937 random(fixtures::test_seed());
  std::uniform_real_distribution<double> part(0, 1);
  const char* const queries[] = {"/distance?from=",
                                 "/distance?from=v:0&at=",
                                 "/path?from=v:0&to=",
                                 "/path?to=v:0&from=",
                                 "/path?from=v:0&to=v:9&via=",
                                 "/table?from=v:0&from=v:5&to=",
                                 "/isolines?levels=2&from=",
                                 "/samples?count=3&from=",
                                 "/trace?direction=1,0,0&length=1&from="};
  for (int round = 0; round < 20; ++round) {
    const double height = 2 * kLimit * part(random);
    const std::string point = above(11 * part(random), 9 * part(random), height);
    for (const char* const query : queries) {
      CAPTURE(query + point);
      const HttpResponse response = plane.service.get(plane.base + query + point);
      REQUIRE(response.status == 200);
      const auto warnings = warnings_of(body_of(response));
      CHECK(warnings.size() == (height > kLimit ? 1 : 0));
      CHECK(header_of(response, "Geo-Warnings") == (warnings.empty() ? "" : warnings.front()));
      if (warnings.empty()) continue;
      const std::string text(query);
      const std::size_t name = text.find_last_of("?&") + 1;
      CHECK(warnings.front().starts_with(
          "The point of " + text.substr(name, text.find_last_of('=') - name) + " is "));
      CHECK(warnings.front().find("max_snap") != std::string::npos);
    }
  }
}

TEST_CASE("AWarningCountsTheFarPointsOfEachParameter") {
  PlaneService plane;
  const auto warnings =
      warnings_of(plane.ask("/table?from=p:1,1,0&from=p:2,2,3&from=p:3,3,4.5"
                            "&to=p:1,1,9&to=v:3&to=p:4,4,0.5"));
  REQUIRE(warnings.size() == 2);
  CHECK(warnings[0].starts_with("2 of 3 points of from are up to 4.5 away"));
  CHECK(warnings[1].starts_with("1 of 3 points of to is 9 away"));
  const HttpResponse posted = plane.service.ask(
      "POST", plane.base + "/distance",
      R"({"from":[{"xyz":[1,1,7]},{"xyz":[1,1,8]},{"vertex":3}],"at":[{"xyz":[1,1,5]}]})");
  REQUIRE(posted.status == 200);
  const auto of_json = warnings_of(body_of(posted));
  REQUIRE(of_json.size() == 2);
  CHECK(of_json[0].starts_with("2 of 3 points of from are up to 8 away"));
  CHECK(of_json[1].starts_with("The point of at is 5 away"));
  CHECK(header_of(posted, "Geo-Warnings") == of_json[0] + "; " + of_json[1]);
}

TEST_CASE("WarningsComeInEveryFormatAndFromTheCacheAndFromJobs") {
  PlaneService plane;
  for (const std::string format :
       {"json", "f32", "f64", "u16", "npy", "frame", "glb", "png", "annotated"}) {
    CAPTURE(format);
    const std::string target = plane.base + "/distance?from=p:1,1,7&format=" + format;
    const std::string said = header_of(plane.service.get(target), "Geo-Warnings");
    CHECK(said.starts_with("The point of from is 7 away"));
    const HttpResponse again = plane.service.get(target);
    CHECK(header_of(again, "Geo-Cache") == "hit");
    CHECK(header_of(again, "Geo-Warnings") == said);
  }
  const HttpResponse batch = plane.service.ask("POST", plane.base + "/batch",
                                               R"({"query":"path","from":"v:0","to":"p:1,1,7"})");
  std::string line;
  REQUIRE(batch.stream);
  REQUIRE(batch.stream(line));
  CHECK(warnings_of(json::parse(line)["reply"]).size() == 1);
}

TEST_CASE("WhoGivesMaxSnapOrAsksForTheNearestPointKnowsHowFarItIs") {
  PlaneService plane;
  const HttpResponse bounded = plane.service.ask("POST", plane.base + "/distance",
                                                 R"({"from":[{"xyz":[1,1,7],"max_snap":8}]})");
  CHECK(bounded.status == 200);
  CHECK(warnings_of(body_of(bounded)).empty());
  CHECK(header_of(bounded, "Geo-Warnings").empty());
  CHECK(warnings_of(plane.ask("/nearest?point=p:1,1,7")).empty());
}
