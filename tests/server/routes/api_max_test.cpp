// What is not farther than `max` has the distance that it has without it, and nothing else has one:
// points inside faces, too, whose corners may all be farther.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/line_tables.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::test_seed;

namespace {

std::vector<double> distances_in(const HttpResponse& response, const json::json_pointer& at) {
  REQUIRE(response.status == 200);
  std::vector<double> numbers;
  const json reply = body_of(response);
  for (const json& d : reply[at]) numbers.push_back(d.is_null() ? kUnreached : d.get<double>());
  return numbers;
}

// Of the paper's front and Novotni's, another value may come of what is left out, here and there.
bool is_sure(const std::string& method) { return method != "wavefront" && method != "novotni"; }

void check_within(const std::string& method, const std::vector<double>& found,
                  const std::vector<double>& whole, double max) {
  REQUIRE(found.size() == whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    CAPTURE(whole[i]);
    if (is_sure(method)) {
      if (whole[i] <= max) {
        CHECK(found[i] == doctest::Approx(whole[i]).epsilon(1e-9));
      } else {
        CHECK(found[i] == kUnreached);
      }
    } else if (whole[i] < 0.5 * max) {
      CHECK(found[i] != kUnreached);
    }
    CHECK((found[i] <= max || found[i] == kUnreached));
  }
}

}  // namespace

TEST_CASE("PointsInFacesWithinAMaximumHaveTheDistanceThatTheyHaveWithoutIt") {
  LineTables plane;
  with_random_meshes(plane, test_seed(), 60, [&](RandomMesh& random, const std::string& base) {
    const char* const methods[] = {"auto",          "exact",    "chen_han",  "steiner",
                                   "fast_marching", "dijkstra", "wavefront", "novotni"};
    const std::string method = methods[random.below(8)];
    CAPTURE(method);
    json asked{{"from", random.below(3) == 0 ? some_vertex(random) : in_some_face(random)},
               {"at", json::array()},
               {"method", method}};
    if (method == "auto" && random.below(2) == 0) asked["bound"] = "upper";
    for (int i = 0; i < 12; ++i) asked["at"].push_back(some_place(random));
    const auto ask = [&] {
      return distances_in(plane.service.ask("POST", base + "/distance", asked.dump()),
                          json::json_pointer("/distances"));
    };
    const std::vector<double> whole = ask();
    json table{{"from", {asked["from"], some_vertex(random)}}, {"to", asked["at"]}};
    table["method"] = method;
    if (asked.contains("bound")) table["bound"] = asked["bound"];
    const std::vector<double> rows = plane.streamed(base, table);
    const std::vector<double> row(rows.begin(), rows.begin() + 12);
    std::vector<double> steps = whole;
    std::sort(steps.begin(), steps.end());
    for (const std::size_t i : {0, 3, 8}) {
      const double max = steps[i] * 1.0001 + 1e-12;
      if (!(max < kUnreached)) continue;
      CAPTURE(max);
      asked["max"] = table["max"] = max;
      check_within(method, ask(), whole, max);
      const std::vector<double> near = plane.streamed(base, table);
      check_within(method, {near.begin(), near.begin() + 12}, row, max);
    }
  });
}

// A cube's faces are larger than what is near in a table of many points.
TEST_CASE("WhatIsNearIsNotEstimatedOnLargeFaces") {
  LineTables plane;
  fixtures::RandomMesh random(test_seed());
  TriangleSoup cube;
  for (int i = 0; i < 8; ++i)
    cube.positions.push_back({1.0 * (i & 1), 0.5 * (i & 2), 0.25 * (i & 4)});
  cube.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const std::string base = plane.add(cube);
  json asked{{"from", json::array()}, {"method", "exact"}};
  for (int i = 0; i < 80; ++i) {
    asked["from"].push_back("f:" + std::to_string(random.below(12)) + "," +
                            std::to_string(0.05 + 0.4 * random.unit()) + "," +
                            std::to_string(0.05 + 0.4 * random.unit()));
  }
  const std::vector<double> whole = plane.streamed(base, asked);
  asked["landmarks"] = 30;
  const std::vector<double> found = plane.streamed(base, asked);
  REQUIRE(found.size() == whole.size());
  // Of points so near to each other, estimates are many times too large.
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (whole[i] < 0.1) CHECK(found[i] == doctest::Approx(whole[i]).epsilon(1e-9));
  }
}
