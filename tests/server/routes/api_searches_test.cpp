// Points for which the surface has to be searched: in compute slots, and no longer than the
// deadline allows.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <string>

#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// So many times the same point, as a body.
std::string points_body(const std::string& point, std::size_t count) {
  json points = json::array();
  for (std::size_t i = 0; i < count; ++i) points.push_back(point);
  return json{{"point", points}, {"deadline_ms", 300}}.dump();
}

}  // namespace

TEST_CASE("PointsAreSearchedInAComputeSlotAndTheRestIsNot") {
  PlaneService plane;
  plane.ask("/nearest?point=p:1,1,1");  // prepares and builds the index
  for (const char* searched : {"p:1,1,1", "p:1e9,0,0", "ray:2.5,3.25,7,0,0,-1"}) {
    const auto before = plane.service.pool.stats().finished;
    plane.ask(std::string("/nearest?point=v:1&point=") + searched + "&point=" + searched);
    CHECK(plane.service.pool.stats().finished == before + 1);
  }
  const auto before = plane.service.pool.stats().finished;
  plane.ask("/nearest?point=v:1&point=f:3,0.2,0.3");
  CHECK(plane.service.pool.stats().finished == before);
}

// From the middle of a sphere each of 80,000 faces is looked at for each point: minutes.
TEST_CASE("ASearchForPointsEndsAtItsDeadline") {
  PlaneService plane;
  const std::string base = plane.add(shapes::icosphere(6));
  REQUIRE(plane.service.get(base + "/nearest?point=p:2,0,0").status == 200);
  const auto begin = std::chrono::steady_clock::now();
  check_problem(plane.service.ask("POST", base + "/nearest", points_body("p:0,0,0", 20'000)), 504,
                "deadline");
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  CHECK(taken.count() < 20);
}

// Points at any distance, drawn anew in each run, searched as quickly as near ones: a search
// that looks at each of the 80,000 faces takes some thousand times as long.
TEST_CASE("FarPointsAreFoundInAHundredTimesTheTimeOfNearOnes") {
  PlaneService plane;
  const std::string base = plane.add(shapes::icosphere(6));
  REQUIRE(plane.service.get(base + "/nearest?point=p:2,0,0").status == 200);
  std::mt19937 random(fixtures::test_seed());
  std::uniform_real_distribution<double> exponent(-30, 59);
  std::normal_distribution<double> normal;
  json near = json::array();
  json points = json::array();
  for (int i = 0; i < 2000; ++i) {
    const double away = 4 + std::pow(10, exponent(random));
    json xyz = json::array();
    json direction = json::array();
    for (int axis = 0; axis < 3; ++axis) {
      direction.push_back(normal(random));
      xyz.push_back(std::clamp(away * normal(random), -9e59, 9e59));
    }
    near.push_back({{"xyz", direction}});
    points.push_back({{"xyz", xyz}});
  }
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const json near_body{{"point", near}};
  REQUIRE(plane.service.ask("POST", base + "/nearest", near_body.dump()).status == 200);
  const std::chrono::duration<double, std::milli> taken = Clock::now() - begin;
  const int patience_ms = 1000 + static_cast<int>(100 * taken.count());
  const json body{{"point", points}, {"deadline_ms", std::min(patience_ms, 600'000)}};
  const HttpResponse reply = plane.service.ask("POST", base + "/nearest", body.dump());
  REQUIRE(reply.status == 200);
  const json answer = body_of(reply);
  for (const json& point : answer["points"]) {
    const double far = point["snap_distance"];
    CHECK(far >= 0);
    CHECK(std::isfinite(far));
  }
}
