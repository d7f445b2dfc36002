#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "proto/wire/query_limits.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// Of the plane's vertex: it has one at each whole x below 12 and y below 10.
double x_of(std::size_t v) { return static_cast<double>(v % 12); }
double y_of(std::size_t v) { return static_cast<double>(v / 12); }

}  // namespace

TEST_CASE("ABoundaryIsAsFarAsTheNearestSide") {
  PlaneService plane;
  const json reply = plane.ask("/distance?from=boundary&method=exact");
  for (std::size_t v = 0; v < 120; ++v) {
    const double wanted = std::min({x_of(v), y_of(v), 11 - x_of(v), 9 - y_of(v)});
    CHECK(std::abs(reply["distances"][v].get<double>() - wanted) < 1e-12);
  }
  REQUIRE(reply["from"].size() == 1);
  CHECK(reply["from"][0]["kind"] == "boundary");
  CHECK(reply["from"][0]["length"] == 40);
  CHECK(reply["from"][0]["pieces"] == 40);
  CHECK_FALSE(reply["from"][0].contains("faces"));
  const json loop = plane.ask("/distance?from=boundary:0&method=exact");
  CHECK(loop["distances"] == reply["distances"]);
  plane.check_same("/distance?from=boundary&method=exact",
                   R"({"from":{"boundary":"all"},"method":"exact"})");
  plane.check_same("/distance?from=boundary:0&method=exact",
                   R"({"from":[{"boundary":0}],"method":"exact"})");
}

// From (1, 4) to (8, 4): at right angles above and below it, and round its ends.
TEST_CASE("ACurveIsAsFarAsItsNearestPlace") {
  PlaneService plane;
  for (const std::string method : {"exact", "chen_han", "auto", "fast_marching"}) {
    CAPTURE(method);
    const json reply = plane.ask("/distance?from=curve:v:49;v:56&method=" + method);
    CHECK(reply["from"][0]["kind"] == "curve");
    CHECK(reply["from"][0]["length"].get<double>() == doctest::Approx(7));
    for (std::size_t v = 0; v < 120; ++v) {
      const double aside = std::max({1 - x_of(v), x_of(v) - 8, 0.0});
      const double wanted = std::hypot(aside, y_of(v) - 4);
      const double error = method == "auto" ? 2e-3 : method == "fast_marching" ? 0.25 : 0;
      const double exact = 1e-12 + error * (1 + wanted);
      CHECK(std::abs(reply["distances"][v].get<double>() - wanted) < exact);
    }
  }
  plane.check_same("/distance?from=curve:closed;v:49;v:56;v:90",
                   R"({"from":{"curve":{"points":[{"vertex":49},"v:56","v:90"],"closed":true}}})");
}

TEST_CASE("PointsAndLabelsOfCurves") {
  PlaneService plane;
  // Below the curve, beside the point, and on the boundary.
  const json reply = plane.ask(
      "/distance?from=v:119&from=curve:v:49;v:56&from=boundary&at=p:4.2,2.7,0&at=p:10.9,8.8,0&at=v:"
      "0"
      "&method=exact&labels=1");
  CHECK(reply["labels"] == json::array({1, 2, 2}));
  CHECK(reply["distances"][0].get<double>() == doctest::Approx(1.3));
  CHECK(reply["distances"][1].get<double>() == doctest::Approx(0.1));
  CHECK(reply["distances"][2] == 0);
  const json all = plane.ask("/distance?from=v:65&from=curve:v:49;v:56&labels=1&method=exact");
  CHECK(all["labels"][65] == 0);
  CHECK(all["labels"][53] == 1);
  CHECK(all["labels"][29] == 1);
}

TEST_CASE("SetsOfFacesAreAtNoDistance") {
  PlaneService plane;
  const json reply = plane.ask(
      "/distance?from=box:2,2,-1,5,6,1&method=exact&at=p:3.3,4.4,0&at=p:8.5,3.5,0&at=v:0");
  CHECK(reply["from"][0]["kind"] == "faces");
  CHECK(reply["from"][0]["faces"] == 24);
  CHECK(reply["from"][0]["length"].get<double>() == doctest::Approx(14));
  CHECK(reply["distances"][0] == 0);
  CHECK(reply["distances"][1].get<double>() == doctest::Approx(3.5));
  CHECK(reply["distances"][2].get<double>() == doctest::Approx(std::sqrt(8.0)));
  for (const std::string method : {"exact", "auto", "dijkstra"}) {
    const json field = plane.ask("/distance?from=box:2,2,-1,5,6,1&method=" + method);
    CHECK(field["distances"][3 + 4 * 12] == 0);
    CHECK(field["distances"][8 + 4 * 12].get<double>() == doctest::Approx(3));
  }
  plane.check_same("/distance?from=faces:7,10-19", R"({"from":{"faces":[7,[10,19]]}})");
}

TEST_CASE("PathsFromCurvesBeginAtTheFoot") {
  PlaneService plane;
  for (const std::string method : {"exact", "chen_han", "auto", "dijkstra", "steiner"}) {
    CAPTURE(method);
    const json reply = plane.ask("/path?from=curve:v:49;v:56&to=p:4.2,7.7,0&method=" + method);
    CHECK(reply["length"].get<double>() == doctest::Approx(3.7).epsilon(1e-9));
    CHECK(reply["points"][0]["xyz"][1].get<double>() == doctest::Approx(4));
    CHECK(reply["points"][0]["xyz"][0].get<double>() == doctest::Approx(4.2));
    CHECK(length_of(reply["points"]) == doctest::Approx(3.7));
    CHECK(reply["from"]["kind"] == "curve");
  }
  const json via = plane.ask("/path?from=boundary&via=p:5,3,0&to=p:5,4,0&method=exact");
  CHECK(via["length"].get<double>() == doctest::Approx(4));
  const json within = plane.ask("/path?from=box:2,2,-1,5,6,1&to=p:3.2,3.3,0&method=exact");
  CHECK(within["length"] == 0);
}

TEST_CASE("OtherFieldsStartFromCurvesToo") {
  PlaneService plane;
  const json lines = plane.ask("/isolines?from=boundary&levels=2&method=exact");
  REQUIRE(lines["isolines"].size() == 1);
  CHECK(lines["isolines"][0]["length"].get<double>() == doctest::Approx(24).epsilon(0.1));
  const json discs = plane.ask("/measure?from=boundary&radii=2&method=exact");
  CHECK(discs["discs"][0]["area"].get<double>() == doctest::Approx(99 - 35).epsilon(0.05));
  const json samples = plane.ask("/samples?from=boundary&count=1&method=exact");
  CHECK(samples["samples"][0]["radius"].get<double>() == doctest::Approx(4));
}

TEST_CASE("WhatIsNoCurveIsRefused") {
  PlaneService plane;
  plane.check_refused("/distance?from=boundary:1", 422, "index_out_of_range", "from[0]");
  plane.check_refused("/distance?from=boundary:x", 400, "bad_syntax", "from[0]");
  plane.check_refused("/distance?from=curve:v:1", 422, "value_out_of_range", "from[0]");
  plane.check_refused("/distance?from=curve:closed;v:1;v:3", 422, "value_out_of_range", "from[0]");
  plane.check_refused("/distance?from=curve:v:1;boundary", 400, "bad_syntax", "from[0].points[1]");
  plane.check_refused("/distance?from=curve:v:1;v:500", 422, "index_out_of_range",
                      "from[0].points[1]");
  plane.check_refused("/distance?from=faces:99999", 422, "index_out_of_range", "from[0].faces[0]");
  plane.check_refused("/distance?from=part:7", 422, "index_out_of_range", "from[0].part");
  plane.check_refused("/distance?from=box:50,50,50,51,51,51", 422, "value_out_of_range", "from[0]");
  plane.check_refused("/path?from=boundary:9&to=v:1", 422, "index_out_of_range", "from");
  plane.check_refused("/voronoi?from=boundary", 400, "bad_syntax", "from[0]");
  plane.check_refused("/table?from=boundary", 400, "bad_syntax", "from[0]");
  plane.check_refused("/path?from=v:0&to=boundary", 400, "bad_syntax", "to");
  for (const std::string method : {"wavefront", "novotni"}) {
    for (const std::string query :
         {"distance?", "isolines?levels=1&", "measure?", "samples?count=2&", "path?to=v:5&"}) {
      plane.check_refused("/" + query + "from=boundary&method=" + method, 422, "value_out_of_range",
                          "method");
    }
  }
  std::string many = "curve:v:0";
  for (std::size_t i = 0; i < proto::kMaxCurvePoints; ++i) many += ";v:1";
  plane.check_refused("/distance?from=" + many, 413, "too_large", "from[0]");
  std::string half = "&from=curve:v:0";
  for (std::size_t i = 0; i < proto::kMaxCurvePoints / 2; ++i) half += ";v:1";
  plane.check_refused("/distance?at=v:0" + half + half, 413, "too_large", "from");
  const auto refuse = [&](const std::string& body, int status, std::string_view code,
                          std::string_view parameter) {
    CAPTURE(body);
    check_problem(plane.service.ask("POST", plane.base + "/distance", body), status, code,
                  parameter);
  };
  refuse(R"({"from":{"boundary":-1}})", 400, "bad_syntax", "from[0].boundary");
  refuse(R"({"from":{"boundary":0,"offset":1}})", 400, "unknown_parameter", "from[0].offset");
  refuse(R"({"from":{"curve":[]}})", 400, "bad_syntax", "from[0].curve");
  refuse(R"({"from":{"curve":{"closed":true}}})", 400, "bad_syntax", "from[0].curve.points");
  refuse(R"({"from":{"curve":{"points":["v:1","v:2","v:3"],"closed":1}}})", 400, "bad_syntax",
         "from[0].curve.closed");
  refuse(R"({"from":{"curve":{"points":["v:1",{"vertex":2,"offset":1}]}}})", 422,
         "value_out_of_range", "from[0].curve.points[1].offset");
  // A closed surface has no boundary, and nothing leads from one piece to another.
  const std::string ball = plane.add(shapes::icosphere(1));
  check_problem(plane.service.get(ball + "/distance?from=boundary"), 422, "value_out_of_range",
                "from[0]");
  TriangleSoup two = shapes::icosphere(0);
  const auto count = static_cast<std::uint32_t>(two.positions.size());
  for (std::uint32_t v = 0; v < count; ++v)
    two.positions.push_back(two.positions[v] + Vec3{9, 0, 0});
  for (std::size_t f = 0; f < 20; ++f) {
    const Triangle t = two.faces[f];
    two.faces.push_back({t[0] + count, t[1] + count, t[2] + count});
  }
  const std::string pair = plane.add(two);
  check_problem(plane.service.get(pair + "/distance?from=curve:v:0;v:1;v:" + std::to_string(count)),
                422, "no_loop", "from[0].points[1]");
}

// As many times as there may be sources.
TEST_CASE("TheSameBoundaryAThousandTimesIsNoMoreWork") {
  PlaneService plane;
  std::string many = "/distance?method=exact";
  for (int i = 0; i < 1000; ++i) many += "&from=boundary";
  const json all = plane.ask(many);
  CHECK(all["distances"] == plane.ask("/distance?method=exact&from=boundary")["distances"]);
  CHECK(all["from"].size() == 1000);
}

TEST_CASE("CurvesOfAPartOfTheSurface") {
  PlaneService plane;
  // The boundary of what is left is nearer.
  const json reply =
      plane.ask("/distance?from=boundary&within=box:0,0,-1,4,9,1&method=exact&at=v:2");
  CHECK(reply["distances"][0] == 0);
  const json inner =
      plane.ask("/distance?from=boundary&within=box:0,0,-1,4,9,1&method=exact&at=p:3,5,0");
  CHECK(inner["distances"][0].get<double>() == doctest::Approx(1));
}
