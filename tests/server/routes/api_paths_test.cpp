// Paths through points, and paths made shortest.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"

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
        const json plain = body_of(plane.service.get(base + "/path?" + ends + by + "&refine=none"));
        const json refined = body_of(plane.service.get(base + "/path?" + ends + by));  // by default
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
  CHECK(plane.ask(query + "&refine=none")["length"] == doctest::Approx(4 + 7 * std::sqrt(2.0)));
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

// Along edges, each segment is in two faces. Which of them a search comes through depends on
// whether a field was there, and on the method.
TEST_CASE("AlongAnEdgeAPathNamesTheFaceOfTheLeastNumber") {
  constexpr std::uint32_t kSide = 75;  // as many vertices as it takes to search for pairs
  const TriangleSoup soup = shapes::plane(kSide, kSide);
  const auto least_face_with = [&](std::uint32_t a, std::uint32_t b) {
    for (std::uint32_t f = 0; f < soup.faces.size(); ++f) {
      const auto& corners = soup.faces[f];
      const auto has = [&](auto v) { return std::ranges::count(corners, v) > 0; };
      if (has(a) && has(b)) return f;
    }
    return kNone;
  };
  const auto vertex_at = [](const json& xyz) {
    return static_cast<std::uint32_t>(std::lround(xyz[0].get<double>()) +
                                      kSide * std::lround(xyz[1].get<double>()));
  };
  const auto is_vertex = [](const json& xyz) {
    return std::ranges::all_of(
        xyz, [](const json& x) { return x.get<double>() == std::round(x.get<double>()); });
  };
  std::mt19937 random(fixtures::test_seed());
  int checked = 0;
  for (const bool is_warm : {false, true}) {
    Config config;
    config.field_cache_bytes = is_warm ? std::uint64_t{1} << 30 : 0;
    config.reply_cache_bytes = 0;
    PlaneService plane(config);
    const std::string base = plane.add(soup);
    for (const std::string method :
         {"auto", "wavefront", "exact", "chen_han", "dijkstra", "fast_marching"}) {
      const auto line = static_cast<std::uint32_t>(random() % kSide);
      const auto begin = static_cast<std::uint32_t>(random() % 40);
      const std::uint32_t end = begin + 5 + static_cast<std::uint32_t>(random() % 25);
      for (const auto& [from, to] : {std::array{line * kSide + begin, line * kSide + end},
                                     std::array{end * kSide + line, begin * kSide + line}}) {
        for (int time = 0; time < (is_warm ? 3 : 1); ++time) {
          const std::string target = base + "/path?from=v:" + std::to_string(from) +
                                     "&to=v:" + std::to_string(to) + "&method=" + method;
          CAPTURE(target);
          const HttpResponse response = plane.service.get(target);
          REQUIRE(response.status == 200);
          const json points = body_of(response)["points"];
          REQUIRE(points.size() > 1);
          for (std::size_t i = 0; i < points.size(); ++i) {
            const std::size_t next = std::min(i + 1, points.size() - 1);
            const std::uint32_t a = vertex_at(points[next - 1]["xyz"]);
            const std::uint32_t b = vertex_at(points[next]["xyz"]);
            // An approximate way round.
            if (!is_vertex(points[next - 1]["xyz"]) || !is_vertex(points[next]["xyz"])) continue;
            if (least_face_with(a, b) == kNone) continue;
            ++checked;
            REQUIRE(points[i]["face"] == least_face_with(a, b));
            const auto& corners = soup.faces[points[i]["face"].get<std::size_t>()];
            Vec3 place{0, 0, 0};
            for (std::size_t c = 0; c < 3; ++c) {
              place = place + points[i]["bary"][c].get<double>() * soup.positions[corners[c]];
            }
            const json& xyz = points[i]["xyz"];
            CHECK(distance(place, Vec3{xyz[0].get<double>(), xyz[1].get<double>(), 0}) < 1e-9);
          }
        }
      }
    }
  }
  CHECK(checked > 200);
}
