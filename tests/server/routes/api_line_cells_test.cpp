// Cells of curves, boundaries and faces.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::test_seed;

namespace {

double area_of_cells(const json& reply) {
  double area = 0;
  for (const json& cell : reply["cells"]) area += cell["area"].get<double>();
  return area;
}

}  // namespace

// The plane has a vertex at each whole x below 12 and y below 10: two lines across it, at y = 1 and
// y = 6.
TEST_CASE("LinesAcrossThePlaneDivideItHalfWayBetweenThem") {
  PlaneService plane;
  const json reply = plane.ask("/voronoi?from=curve:v:12;v:23&from=curve:v:72;v:83&method=exact");
  CHECK(reply["from"][0]["kind"] == "curve");
  REQUIRE(reply["cells"].size() == 2);
  CHECK(reply["cells"][0]["site"] == reply["from"][0]);
  CHECK(reply["cells"][0]["area"].get<double>() == doctest::Approx(11 * 3.5));
  CHECK(reply["cells"][1]["area"].get<double>() == doctest::Approx(11 * 5.5));
  CHECK(reply["cells"][0]["vertices"] == 48);
  REQUIRE(reply["bisectors"].size() == 1);
  CHECK(reply["bisectors"][0]["length"].get<double>() == doctest::Approx(11));
  for (const json& point : reply["bisectors"][0]["points"]) {
    CHECK(std::abs(point[1].get<double>() - 3.5) < 1e-9);
  }
  CHECK(reply["neighbors"][0]["cells"] == json::array({0, 1}));
  CHECK(reply["triangles"].empty());
  plane.check_same("/voronoi?from=curve:v:12;v:23&from=boundary:0&from=v:65&from=faces:1-3",
                   R"({"from":[{"curve":{"points":["v:12","v:23"]}},{"boundary":0},"v:65",)"
                   R"({"faces":[[1,3]]}]})");
}

// Faces with x below 4, with x from 4 to 8, and the boundary: what is left is nearer to one of
// them.
TEST_CASE("FacesAreInTheCellOfTheirSite") {
  PlaneService plane;
  const json all = plane.ask("/voronoi?from=box:0,0,-1,4,9,1&from=box:4,0,-1,11,9,1&method=exact");
  CHECK(all["from"][0]["faces"] == 72);
  CHECK(all["cells"][0]["area"].get<double>() == doctest::Approx(36));
  CHECK(all["cells"][1]["area"].get<double>() == doctest::Approx(63));
  CHECK(all["neighbors"][0]["length"].get<double>() == doctest::Approx(9));
  REQUIRE(all["bisectors"].size() == 1);
  CHECK(all["bisectors"][0]["points"].size() == 10);
  const json some =
      plane.ask("/voronoi?from=boundary&from=box:4,3,-1,7,6,1&from=v:64&method=exact");
  CHECK(area_of_cells(some) == doctest::Approx(99));
  // The rectangle is 3 from the lower and the upper side, 4 from the others; the point is on it.
  CHECK(some["cells"][1]["area"].get<double>() == doctest::Approx(6.5 * 6).epsilon(0.05));
  CHECK(some["cells"][2]["area"] == 0);
}

TEST_CASE("CellsOfLinesAgreeWithTheLabelsOfDistances") {
  std::mt19937 random(test_seed());
  PlaneService plane;
  for (int round = 0; round < 4; ++round) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const std::string base = plane.add(shapes::terrain(24, 4, number));
    const auto point = [&] {
      const std::string weight = std::to_string(0.05 + 0.4 * (random() / 4294967296.0));
      return "f:" + std::to_string(random() % 1000) + "," + weight + ",0.3";
    };
    const std::string first = std::to_string(random() % 900);
    const std::vector<std::string> sites{
        "boundary", "curve:" + point() + ";" + point(),
        "curve:closed;" + point() + ";" + point() + ";" + point(), point(),
        "faces:" + first + "," + std::to_string(1000 + random() % 50)};
    std::string from = "?from=" + sites[0];
    for (std::size_t i = 1; i < sites.size(); ++i) from += "&from=" + sites[i];
    CAPTURE(from);
    for (const std::string method : {"&method=exact", "&method=chen_han"}) {
      CAPTURE(method);
      const json reply = body_of(plane.service.get(base + "/voronoi" + from + method));
      const json field =
          body_of(plane.service.get(base + "/distance" + from + "&labels=1" + method));
      std::vector<json> alone;
      for (const std::string& site : sites) {
        alone.push_back(
            body_of(plane.service.get(base + "/distance?from=" + site + method))["distances"]);
      }
      // Vertices of each label, and those that are as near to the site as to the nearest one.
      std::vector<int> labels(sites.size());
      std::vector<int> surely(sites.size());
      std::vector<int> maybe(sites.size());
      for (std::size_t v = 0; v < field["labels"].size(); ++v) {
        ++labels[field["labels"][v].get<std::size_t>()];
        std::vector<std::size_t> near;
        for (std::size_t i = 0; i < sites.size(); ++i) {
          const double least = field["distances"][v];
          if (alone[i][v].get<double>() <= least + 1e-6) near.push_back(i);
        }
        REQUIRE_FALSE(near.empty());
        for (const std::size_t i : near) ++(near.size() == 1 ? surely : maybe)[i];
      }
      double outlines = 0;
      for (std::size_t i = 0; i < sites.size(); ++i) {
        const int vertices = reply["cells"][i]["vertices"];
        CHECK(vertices >= surely[i]);
        CHECK(vertices <= surely[i] + maybe[i]);
        CHECK(std::abs(vertices - labels[i]) <= maybe[i]);
        outlines += reply["cells"][i]["perimeter"].get<double>();
      }
      for (const json& pair : reply["neighbors"]) outlines -= 2 * pair["length"].get<double>();
      CHECK(std::abs(outlines) < 1e-6);
      const json mesh = body_of(plane.service.get(base));
      CHECK(area_of_cells(reply) == doctest::Approx(mesh["area"].get<double>()));
    }
  }
}

TEST_CASE("CellsOfLinesByEveryMethodAndOnPartsOfTheSurface") {
  PlaneService plane;
  for (const std::string method : {"auto", "exact", "chen_han", "wavefront", "novotni",
                                   "fast_marching", "dijkstra", "steiner"}) {
    CAPTURE(method);
    const json reply = plane.ask(
        "/voronoi?from=curve:v:12;v:23&from=v:65&from=faces:100,101&from=boundary:0&method=" +
        method);
    CHECK(reply["method"] == method);
    CHECK(area_of_cells(reply) == doctest::Approx(99));
  }
  const json part = plane.ask(
      "/voronoi?from=curve:v:0;v:11&from=boundary:0&forbid=box:0,8,-1,11,9,1&method=exact");
  CHECK(area_of_cells(part) == doctest::Approx(88));
  const json walled =
      plane.ask("/voronoi?from=curve:v:0;v:11&from=v:117&walls=v:48;v:59&method=exact");
  // The wall is at y = 4, from side to side.
  CHECK(walled["cells"][0]["area"].get<double>() == doctest::Approx(44));
  CHECK(walled["cells"][1]["area"].get<double>() == doctest::Approx(55));
}

TEST_CASE("DrawingsOfCellsOfLines") {
  PlaneService plane;
  const std::string target = "/voronoi?from=curve:v:12;v:23&from=faces:150-160&method=exact";
  for (const std::string more : {"&format=glb", "&part=cells", "&part=bisectors"}) {
    const HttpResponse drawn = plane.service.get(plane.base + target + more);
    CAPTURE(more);
    REQUIRE(drawn.status == 200);
    CHECK(drawn.content_type == "model/gltf-binary");
  }
  const HttpResponse picture =
      plane.service.get(plane.base + target + "&format=png&width=120&height=90");
  CHECK(picture.content_type == "image/png");
}

TEST_CASE("CellsOfLinesThatAreRefused") {
  PlaneService plane;
  const std::string line = "/voronoi?from=v:3&from=curve:v:12;v:23";
  plane.check_refused(line + "&relax=1", 422, "value_out_of_range", "relax");
  CHECK(plane.ask(line + "&relax=0")["relax"] == 0);
  plane.check_refused(line + "&part=delaunay", 422, "value_out_of_range", "part");
  plane.check_refused(line + "&from=boundary:1", 422, "index_out_of_range", "from[2]");
  plane.check_refused(line + "&from=part:7", 422, "index_out_of_range", "from[2].part");
  plane.check_refused(line + "&from=curve:v:1", 422, "value_out_of_range", "from[2]");
  check_problem(
      plane.service.ask("POST", plane.base + "/voronoi", R"({"from":[{"boundary":0,"offset":1}]})"),
      400, "unknown_parameter", "from[0].offset");
  // Points among them may have offsets.
  const json late = body_of(
      plane.service.ask("POST", plane.base + "/voronoi",
                        R"({"from":["boundary",{"vertex":65,"offset":1}],"method":"exact"})"));
  const json even = plane.ask("/voronoi?from=boundary&from=v:65&method=exact");
  CHECK(late["cells"][1]["area"].get<double>() < even["cells"][1]["area"].get<double>() - 1);
}

TEST_CASE("CellsOfLinesAskForTheirMemoryAndEndAtTheirDeadline") {
  Config config;
  config.query_memory_bytes = 4 << 20;
  PlaneService plane(config);
  const std::string base = plane.add(shapes::terrain(150, 10, 7));
  check_problem(plane.service.get(base + "/voronoi?from=boundary&from=v:7&method=exact"), 422,
                "too_much_memory");
  PlaneService other;
  const std::string ball = other.add(shapes::icosphere(6));
  std::string target = ball + "/voronoi?method=exact&deadline_ms=50";
  for (int i = 0; i < 400; ++i) target += "&from=faces:" + std::to_string(100 * i);
  check_problem(other.service.get(target), 504, "deadline", "");
}
