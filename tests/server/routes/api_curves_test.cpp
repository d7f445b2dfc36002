#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <string_view>

#include "core/mesh/shapes.h"
#include "proto/wire/query_limits.h"
#include "tests/fixtures/test_seed.h"
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

TEST_CASE("TheMetadataListsTheLoopsOfTheBoundary") {
  PlaneService plane;
  const json mesh = plane.ask("");
  CHECK(mesh["boundaries"] ==
        json::array({{{"length", 40.0}, {"edges", 40}, {"closed", true}, {"vertex", 0}}}));
  // 102 faces that touch nobody, the later the larger, of which the longest 100 are listed.
  TriangleSoup soup;
  constexpr std::uint32_t kFaces = 102;
  for (std::uint32_t f = 0; f < kFaces; ++f) {
    const double z = 2 * f;
    const double side = 1 + f;
    soup.positions.push_back({0, 0, z});
    soup.positions.push_back({3 * side, 0, z});
    soup.positions.push_back({0, 4 * side, z});
    soup.faces.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  const std::string base = plane.add(soup);
  const json many = body_of(plane.service.get(base));
  CHECK(many["boundary_loops"] == kFaces);
  REQUIRE(many["boundaries"].size() == 100);
  for (std::uint32_t k = 0; k < 100; ++k) {
    const json& loop = many["boundaries"][k];
    CHECK(loop["length"] == 12.0 * (kFaces - k));
    CHECK(loop["edges"] == 3);
    CHECK(loop["vertex"] == 3 * (kFaces - 1 - k));
  }
  // The same one as a source.
  const json from = body_of(plane.service.get(
      base + "/distance?from=boundary:7&at=v:" + many["boundaries"][7]["vertex"].dump()));
  CHECK(from["distances"][0] == 0);
  CHECK(from["from"][0]["length"] == many["boundaries"][7]["length"]);
  CHECK(body_of(plane.service.get("/v1/meshes/" +
                                  plane.service.upload(glb_of(shapes::icosphere(1)))))["boundaries"]
            .empty());
}

// From (1, 4) to (8, 4): at right angles above and below it, and round its ends.
TEST_CASE("ACurveIsAsFarAsItsNearestPlace") {
  PlaneService plane;
  for (const std::string method :
       {"exact", "chen_han", "auto", "wavefront", "novotni", "fast_marching"}) {
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
  plane.check_refused("/distance?from=curve:v:1;boundary", 422, "value_out_of_range",
                      "from[0].points[1]");
  plane.check_refused("/distance?from=curve:v:1;v:500", 422, "index_out_of_range",
                      "from[0].points[1]");
  plane.check_refused("/distance?from=faces:99999", 422, "index_out_of_range", "from[0].faces[0]");
  plane.check_refused("/distance?from=part:7", 422, "index_out_of_range", "from[0].part");
  plane.check_refused("/distance?from=box:50,50,50,51,51,51", 422, "value_out_of_range", "from[0]");
  plane.check_refused("/path?from=boundary:9&to=v:1", 422, "index_out_of_range", "from");
  for (const std::string line : {"boundary", "boundary:0", "curve:v:1;v:7", "faces:1", "part:0",
                                 "part:test", "material:0", "material:glass", "material:none",
                                 "sphere:0,0,0,1", "box:0,0,0,1,1,1", "inside:v:0;v:5;v:60"}) {
    plane.check_refused("/path?from=v:0&to=" + line, 422, "value_out_of_range", "to");
    plane.check_refused("/distance?from=v:0&at=" + line, 422, "value_out_of_range", "at[0]");
    plane.check_refused("/logmap?radius=2&from=" + line, 422, "value_out_of_range", "from");
    plane.check_refused("/trace?angle=0&length=1&from=" + line, 422, "value_out_of_range", "from");
    plane.check_refused("/loop?around=v:0&around=v:5&around=" + line, 422, "value_out_of_range",
                        "around[2]");
    plane.check_refused("/distance?from=v:0&walls=" + line + ";v:1", 422, "value_out_of_range",
                        "walls.points[0]");
  }
  plane.check_refused("/distance?from=inside:v:0;v:5;v:60", 422, "value_out_of_range", "from[0]");
  for (const json& region :
       {json{{"faces", {1}}}, json{{"part", 0}}, json{{"material", nullptr}},
        json{{"material", "glass"}}, json{{"inside", {"v:0", "v:5", "v:60"}}}}) {
    CAPTURE(region.dump());
    check_problem(plane.service.ask("POST", plane.base + "/path",
                                    json{{"from", "v:0"}, {"to", region}}.dump()),
                  422, "value_out_of_range", "to");
  }
  plane.check_refused("/voronoi?from=boundaries", 400, "bad_syntax", "from[0]");
  check_problem(plane.service.ask("POST", plane.base + "/table", R"({"from":[{"curve":[]}]})"), 400,
                "bad_syntax", "from[0].curve");
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

namespace {

// Of a rectangle's sides, below 0 inside.
double to_rectangle(double x, double y, double left, double low, double right, double high) {
  const double across = std::max(left - x, x - right);
  const double up = std::max(low - y, y - high);
  if (across <= 0 && up <= 0) return std::max(across, up);
  return std::hypot(std::max(across, 0.0), std::max(up, 0.0));
}

// From (2, 2) to (8, 7).
constexpr const char* kRound = "/distance?from=curve:closed;v:26;v:32;v:92;v:86";

}  // namespace

TEST_CASE("DistancesHaveASignInsideAClosedCurve") {
  PlaneService plane;
  for (const std::string method : {"exact", "auto", "dijkstra"}) {
    CAPTURE(method);
    const std::string asked = kRound + ("&method=" + method);
    const json plain = plane.ask(asked);
    CHECK_FALSE(plain.contains("signed"));
    const json reply = plane.ask(asked + "&signed=1");
    CHECK(reply["signed"] == true);
    CHECK(reply["max"] == plain["max"]);
    CHECK(reply["farthest"] == plain["farthest"]);
    for (std::size_t v = 0; v < 120; ++v) {
      const double found = reply["distances"][v];
      CHECK(std::abs(found) == plain["distances"][v]);
      const double wanted = to_rectangle(x_of(v), y_of(v), 2, 2, 8, 7);
      CHECK((found < 0) == (wanted < 0));
      if (method == "exact") CHECK(std::abs(found - wanted) < 1e-12);
    }
  }
  // The smaller side of (1, 1) to (10, 8) is about it.
  const json large = plane.ask(
      "/distance?from=curve:closed;v:13;v:22;v:106;v:97&signed=1&method=exact&at=v:65&at=v:0");
  CHECK(large["distances"][0].get<double>() == doctest::Approx(3));
  CHECK(large["distances"][1].get<double>() == doctest::Approx(-std::sqrt(2)));
  plane.check_same(
      std::string(kRound) + "&signed=1",
      R"({"from":{"curve":{"points":["v:26","v:32","v:92","v:86"],"closed":true}},"signed":true})");
}

TEST_CASE("SignsOfPointsFormatsAndDigits") {
  PlaneService plane;
  const std::string asked = std::string(kRound) + "&signed=1&method=exact";
  const json at = plane.ask(asked + "&at=p:2.6,4.3,0&at=p:1.4,4.3,0&at=v:26&at=p:9.5,3,0&labels=1");
  const double wanted[] = {-0.6, 0.6, 0, 1.5};
  for (int i = 0; i < 4; ++i) CHECK(std::abs(at["distances"][i].get<double>() - wanted[i]) < 1e-12);
  CHECK(at["labels"] == json::array({0, 0, 0, 0}));
  CHECK_FALSE(at["distances"].dump().find("-0.0") == 1);
  // Beyond max nothing has a sign.
  const json near = plane.ask(asked + "&max=1");
  for (std::size_t v = 0; v < 120; ++v) {
    const double d = to_rectangle(x_of(v), y_of(v), 2, 2, 8, 7);
    CHECK(near["distances"][v].is_null() == (std::abs(d) > 1));
  }
  const json whole = plane.ask(asked);
  const HttpResponse bytes = plane.service.get(plane.base + asked + "&format=f64");
  REQUIRE(bytes.status == 200);
  REQUIRE(bytes.body->size() == 120 * sizeof(double));
  for (std::size_t v = 0; v < 120; ++v) {
    double d = 0;
    std::memcpy(&d, bytes.body->data() + v * sizeof d, sizeof d);
    CHECK(d == whole["distances"][v].get<double>());
  }
  for (const char* format : {"f32", "npy", "frame", "glb", "annotated"}) {
    CHECK(plane.service.get(plane.base + asked + "&format=" + format).status == 200);
  }
  for (const char* format : {"u16", "png"}) {
    plane.check_refused(asked + "&format=" + format, 406, "not_acceptable", "format");
  }
  plane.check_refused(asked + "&at=v:0&format=glb", 406, "not_acceptable", "format");
  plane.check_refused(asked + "&labels=1&format=annotated", 406, "not_acceptable", "format");
  // An upper bound is one of the length: inside it is rounded down.
  const std::string upper = std::string(kRound) + "&signed=1&bound=upper&at=p:4.123456,4.2345678,0";
  const double exact = plane.ask(upper)["distances"][0];
  const double cut = plane.ask(upper + "&precision=3")["distances"][0];
  CHECK(exact < -2.123);
  CHECK(cut <= exact);
  CHECK(cut > exact - 0.011);
}

TEST_CASE("WhatHasNoSidesHasNoSign") {
  PlaneService plane;
  for (const char* from : {"from=v:0", "from=boundary", "from=curve:v:26;v:32;v:92",
                           "from=faces:0-9", "from=curve:closed;v:26;v:32;v:92&from=v:0"}) {
    plane.check_refused("/distance?" + std::string(from) + "&signed=1", 422, "value_out_of_range",
                        "signed");
    CHECK(plane.service.get(plane.base + "/distance?" + from + "&signed=0").status == 200);
  }
  plane.check_refused(std::string(kRound) + "&signed=maybe", 400, "bad_syntax", "signed");
  // There and back again.
  plane.check_refused("/distance?from=curve:closed;v:26;v:32;v:29&signed=1", 422,
                      "value_out_of_range", "signed");
  constexpr std::uint32_t kAround = 8;
  const std::string knot = plane.add(shapes::torus_knot(40, kAround, 0.3));
  const std::string ring = "/distance?from=curve:closed;v:0;v:2;v:5";
  CHECK(plane.service.get(knot + ring).status == 200);
  check_problem(plane.service.get(knot + ring + "&signed=1"), 422, "value_out_of_range", "signed");
}

TEST_CASE("SignsOnAPartOfTheSurface") {
  PlaneService plane;
  const std::string asked = std::string(kRound) + "&signed=1&method=exact";
  const json whole = plane.ask(asked);
  // A wall inside, which is across no way to the line, splits faces and doubles vertices.
  const json walled = plane.ask(asked + "&walls=p:4.1,4.5,0;p:6.1,4.5,0");
  for (std::size_t v = 0; v < 120; ++v) {
    CHECK(walled["distances"][v].get<double>() ==
          doctest::Approx(whole["distances"][v].get<double>()));
  }
  CHECK(
      plane.service.get(plane.base + asked + "&walls=p:4.1,4.5,0;p:6.1,4.5,0&format=glb").status ==
      200);
  const json near = plane.ask(asked + "&walls=p:4.1,4.5,0;p:6.1,4.5,0&at=p:5.05,4.6,0&at=p:1,1,0");
  CHECK(near["distances"][0].get<double>() == doctest::Approx(-2.4));
  CHECK(near["distances"][1].get<double>() == doctest::Approx(std::sqrt(2)));
  // A hole in the middle: what is left inside has a sign.
  const json part = plane.ask(asked + "&forbid=box:4,4,-1,6,5,1");
  CHECK(part["distances"][3 + 3 * 12].get<double>() == doctest::Approx(-1));
  CHECK(part["distances"][0].get<double>() == doctest::Approx(std::sqrt(8)));
}

TEST_CASE("WhatIsSaidOfLinesDependsOnNothingThatWasAskedBefore") {
  std::mt19937 random(fixtures::test_seed());
  const auto below = [&](std::uint32_t limit) {
    return static_cast<std::uint32_t>(random() % limit);
  };
  for (int round = 0; round < 6; ++round) {
    CAPTURE(round);
    const TriangleSoup soup = shapes::terrain(12 + below(8), 2.0, random());
    const auto vertices = static_cast<std::uint32_t>(soup.positions.size());
    const auto faces = static_cast<std::uint32_t>(soup.faces.size());
    const std::string curve =
        "curve:v:" + std::to_string(below(vertices)) + ";v:" + std::to_string(below(vertices));
    const std::string patch = "faces:" + std::to_string(below(faces));
    const std::string from =
        "from=" + std::array<std::string, 3>{curve, "boundary", patch}[below(3)];
    const std::string point = "f:" + std::to_string(below(faces)) + ",0.2,0.3";
    for (const char* method :
         {"auto", "exact", "fast_marching", "dijkstra", "auto&tolerance=0.001"}) {
      const std::string asked = from + "&method=" + method;
      CAPTURE(asked);
      CAPTURE(point);
      const std::string at = "/distance?at=" + point + "&" + asked;
      const std::string path = "/path?to=" + point + "&" + asked;
      PlaneService first;
      PlaneService later;
      const std::string fresh = first.add(soup);
      const std::string known = later.add(soup);

      (void)body_of(later.service.get(known + "/distance?" + asked));
      const auto distance = [&](PlaneService& plane, const std::string& base) {
        return body_of(plane.service.get(base + at))["distances"][0].get<double>();
      };
      const double wanted = distance(first, fresh);
      CHECK(distance(later, known) == doctest::Approx(wanted).epsilon(1e-4));
      if (std::string_view(method).find('&') != std::string_view::npos) continue;
      const double length = body_of(first.service.get(fresh + path))["length"].get<double>();
      CHECK(body_of(later.service.get(known + path))["length"].get<double>() ==
            doctest::Approx(length).epsilon(1e-4));
      // A path by `auto` is one by `exact`.
      if (std::string_view(method) != "auto") continue;
      const std::string exact = "/distance?at=" + point + "&" + from + "&method=exact";
      const double truth = body_of(first.service.get(fresh + exact))["distances"][0].get<double>();
      CHECK(length == doctest::Approx(truth).epsilon(1e-6));
      CHECK(wanted == doctest::Approx(truth).epsilon(2e-3));
    }
  }
}

TEST_CASE("PathsFromLinesByAutoNeedNoMoreMemoryThanAQueryHas") {
  const TriangleSoup soup = shapes::terrain(90, 6.0, fixtures::test_seed());
  const std::string middle = "v:" + std::to_string(45 * 90 + 45);
  PlaneService plenty;
  const std::string path = plenty.add(soup) + "/path?from=boundary&to=" + middle;
  const double truth = body_of(plenty.service.get(path))["length"].get<double>();
  bool is_refused_by_exact = false;
  for (std::uint64_t bytes = 64 << 20; bytes >= 4 << 20; bytes -= bytes / 8) {
    CAPTURE(bytes);
    Config config;
    config.query_memory_bytes = bytes;
    PlaneService little(config);
    const std::string asked = little.add(soup) + "/path?from=boundary&to=" + middle;
    const HttpResponse exact = little.service.get(asked + "&method=exact");
    const HttpResponse found = little.service.get(asked);
    if (exact.status == 200) {
      CHECK(body_of(found)["length"].get<double>() == doctest::Approx(truth).epsilon(1e-6));
      continue;
    }
    check_problem(exact, 422, "too_much_memory", "");
    is_refused_by_exact = true;
    REQUIRE(found.status == 200);
    CHECK(body_of(found)["length"].get<double>() == doctest::Approx(truth).epsilon(0.2));
    break;
  }
  CHECK(is_refused_by_exact);
}
