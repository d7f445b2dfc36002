#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("SamplesOfAPlaneAreWherePythagorasPutsThem") {
  PlaneService plane;
  const json reply = plane.ask("/samples?count=4");
  CHECK(reply["mesh"] == plane.id);
  CHECK(reply["method"] == "auto");
  CHECK(reply["from"].empty());
  REQUIRE(reply["samples"].size() == 4);
  // (10, 0) is as far from (11, 9) as it can be and not nearer to (0, 0); likewise (1, 9).
  const std::vector<int> expected{0, 119, 10, 109};
  for (int i = 0; i < 4; ++i) {
    CHECK(reply["samples"][i]["vertex"] == expected[i]);
    CHECK(reply["samples"][i]["xyz"] ==
          json::array({double(expected[i] % 12), double(expected[i] / 12), 0.0}));
  }
  CHECK(reply["samples"][0]["radius"].is_null());
  CHECK(reply["samples"][1]["radius"] == doctest::Approx(std::hypot(11, 9)));
  CHECK(reply["samples"][2]["radius"] == doctest::Approx(std::hypot(1, 9)));
  CHECK(reply["samples"][3]["radius"] == doctest::Approx(std::hypot(1, 9)));
  // Nothing is farther than the middle.
  CHECK(reply["covering_radius"].get<double>() <= std::hypot(5.5, 4.5));
}

TEST_CASE("SamplesFromGivenPointsAndMoreThanThereAreVertices") {
  PlaneService plane;
  const json one = plane.ask("/samples?count=1&from=v:0&from=v:11");
  CHECK(one["from"].size() == 2);
  REQUIRE(one["samples"].size() == 1);
  CHECK(one["samples"][0]["vertex"] == 113);  // (5, 9), as far from both as can be
  CHECK(one["samples"][0]["radius"] == doctest::Approx(std::hypot(5, 9)));
  const json all = plane.ask("/samples?count=10000");
  CHECK(all["samples"].size() == 120);
  CHECK(all["covering_radius"] == 0);
  std::set<int> vertices;
  double before = INFINITY;
  for (std::size_t i = 1; i < 120; ++i) {
    vertices.insert(all["samples"][i]["vertex"].get<int>());
    CHECK(all["samples"][i]["radius"] <= before);
    before = all["samples"][i]["radius"];
  }
  CHECK(vertices.size() == 119);
}

TEST_CASE("SamplesReachEveryComponentFirst") {
  PlaneService plane;
  const std::string base = plane.add(fixtures::two_components());
  const json one = body_of(plane.service.get(base + "/samples?count=1"));
  CHECK(one["samples"][0]["vertex"] == 0);
  CHECK(one["covering_radius"].is_null());
  const json three = body_of(plane.service.get(base + "/samples?count=3"));
  CHECK(three["samples"][1]["vertex"] == 25);
  CHECK(three["samples"][1]["radius"].is_null());
  CHECK(three["samples"][2]["radius"] == doctest::Approx(std::hypot(4, 4)));
}

TEST_CASE("CoveringRadiusIsTheGreatestDistanceFromTheSamples") {
  PlaneService plane;
  const std::string base = plane.add(shapes::terrain(30, 4, 2));
  for (const std::string by : {"&method=wavefront", "&method=dijkstra"}) {
    const json reply = body_of(plane.service.get(base + "/samples?count=9" + by));
    std::string query = "/distance?" + by.substr(1);
    for (const json& sample : reply["samples"]) {
      query += "&from=v:" + std::to_string(sample["vertex"].get<int>());
    }
    const json field = body_of(plane.service.get(base + query));
    CHECK(reply["covering_radius"].get<double>() ==
          doctest::Approx(field["max"].get<double>()).epsilon(0.02));
  }
}

TEST_CASE("SamplesByGetAndPost") {
  PlaneService plane;
  plane.check_same("/samples?count=5&from=v:7&method=dijkstra&precision=7",
                   R"({"count":5,"from":{"vertex":7},"method":"dijkstra","precision":7})");
}

TEST_CASE("SamplesThatAreRefused") {
  PlaneService plane;
  plane.check_refused("/samples", 400, "bad_syntax", "count");
  plane.check_refused("/samples?count=x", 400, "bad_syntax", "count");
  plane.check_refused("/samples?count=0", 422, "value_out_of_range", "count");
  plane.check_refused("/samples?count=10001", 413, "too_large", "count");
  plane.check_refused("/samples?count=3&from=v:120", 422, "index_out_of_range", "from[0]");
  plane.check_refused("/samples?count=3&method=magic", 422, "method_unknown", "method");
  plane.check_refused("/samples?count=3&max=3", 400, "unknown_parameter", "max");
  plane.check_refused("/samples?count=3&format=f64", 406, "not_acceptable", "format");
}

TEST_CASE("LimitsCanBeRead") {
  PlaneService plane;
  const json limits = body_of(plane.service.get("/v1/status"))["limits"];
  CHECK(limits["max_sources"] == 1000);
  CHECK(limits["max_points"] == 100'000);
  CHECK(limits["max_via"] == 100);
  CHECK(limits["max_loop_points"] == 100);
  CHECK(limits["max_table_entries"] == 1'000'000);
  CHECK(limits["max_streamed_entries"] == 1'000'000'000);
  CHECK(limits["max_sparse_entries"] == 20'000'000);
  CHECK(limits["max_steiner_nodes"] == 20'000'000);
  CHECK(limits["max_levels"] == 10'000);
  CHECK(limits["max_isoline_segments"] == 1'000'000);
  CHECK(limits["max_samples"] == 10'000);
  CHECK(limits["max_radii"] == 1000);
  CHECK(limits["max_relax"] == 100);
  CHECK(limits["max_fields"] == 1'000);
}
