#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <string>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

json voronoi_gltf(const HttpResponse& reply) {
  REQUIRE(reply.status == 200);
  REQUIRE(reply.content_type == "model/gltf-binary");
  std::uint32_t length = 0;
  std::memcpy(&length, reply.body->data() + 12, sizeof length);
  return json::parse(reply.body->substr(20, length));
}

}  // namespace

// The plane has a vertex at each whole x below 12 and y below 10: three cells between x = 0 and 11.
TEST_CASE("ThreeSitesDivideThePlane") {
  PlaneService plane;
  // (1, 4), (5, 4) and (3, 7).
  const json reply = plane.ask("/voronoi?from=v:49&from=v:53&from=v:87&method=exact");
  CHECK(reply["mesh"] == plane.id);
  CHECK(reply["method"] == "exact");
  CHECK(reply["relax"] == 0);
  CHECK(reply["from"].size() == 3);
  CHECK_FALSE(reply.contains("warnings"));
  REQUIRE(reply["cells"].size() == 3);
  double area = 0;
  int vertices = 0;
  for (const json& cell : reply["cells"]) {
    area += cell["area"].get<double>();
    vertices += cell["vertices"].get<int>();
    CHECK(cell["centroid"]["snap_distance"] == 0);
  }
  CHECK(area == doctest::Approx(99));
  CHECK(vertices == 120);
  CHECK(reply["cells"][1]["site"]["vertex"] == 53);
  // The three are as far from (3, 4 + 5/6): 13/6.
  REQUIRE(reply["triangles"].size() == 1);
  const json& meeting = reply["triangles"][0];
  CHECK(meeting["cells"] == json::array({0, 1, 2}));
  CHECK(meeting["point"]["xyz"][0].get<double>() == doctest::Approx(3));
  CHECK(meeting["point"]["xyz"][1].get<double>() == doctest::Approx(4 + 5.0 / 6));
  CHECK(meeting["distance"].get<double>() == doctest::Approx(13.0 / 6));
  REQUIRE(reply["neighbors"].size() == 3);
  CHECK(reply["neighbors"][0]["cells"] == json::array({0, 1}));
  CHECK(reply["neighbors"][0]["length"].get<double>() == doctest::Approx(4 + 5.0 / 6));
  REQUIRE(reply["bisectors"].size() == 3);
  for (const json& line : reply["bisectors"]) {
    CHECK(line["closed"] == false);
    CHECK(line["length"].get<double>() == doctest::Approx(length_of(line["points"])));
  }
  const double outline = reply["cells"][0]["perimeter"].get<double>();
  CHECK(outline == doctest::Approx(reply["neighbors"][0]["length"].get<double>() +
                                   reply["neighbors"][1]["length"].get<double>()));
}

TEST_CASE("CellsAgreeWithTheLabelsOfDistances") {
  PlaneService plane;
  const std::string base = plane.add(shapes::terrain(30, 4, 2));
  for (const std::string method : {"auto", "exact", "dijkstra"}) {
    const std::string from = "?from=v:7&from=f:900,0.2,0.3&from=v:700&method=" + method;
    const json cells = body_of(plane.service.get(base + "/voronoi" + from))["cells"];
    const json labels =
        body_of(plane.service.get(base + "/distance" + from + "&labels=1"))["labels"];
    std::vector<int> counts(3);
    for (const json& label : labels) ++counts[label.get<std::size_t>()];
    for (std::size_t i = 0; i < 3; ++i) {
      // But for ties, of which lengths along edges have some.
      CHECK(std::abs(cells[i]["vertices"].get<int>() - counts[i]) <=
            (method == "dijkstra" ? 9 : 1));
    }
  }
}

TEST_CASE("RelaxedSitesAreTheCentroidsOfTheRoundBefore") {
  PlaneService plane;
  const std::string sites = "/voronoi?from=v:0&from=v:1&from=v:14&method=exact";
  const json before = plane.ask(sites);
  const json after = plane.ask(sites + "&relax=1");
  CHECK(after["relax"] == 1);
  CHECK(after["from"] == before["from"]);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(after["cells"][i]["site"] == before["cells"][i]["centroid"]);
  }
  const json settled = plane.ask(sites + "&relax=100");
  for (const json& cell : settled["cells"]) {
    CHECK(cell["area"].get<double>() > 25);
    CHECK(distance({cell["site"]["xyz"][0], cell["site"]["xyz"][1], 0},
                   {cell["centroid"]["xyz"][0], cell["centroid"]["xyz"][1], 0}) < 0.05);
  }
}

TEST_CASE("ACellWithoutAreaHasNoCentroid") {
  PlaneService plane;
  const json reply = plane.ask("/voronoi?from=v:3&from=v:3&relax=0");
  CHECK(reply["cells"][0]["area"] == doctest::Approx(99));
  CHECK(reply["cells"][1]["area"] == 0);
  CHECK(reply["cells"][1]["centroid"].is_null());
  CHECK(reply["triangles"].empty());
  CHECK(reply["bisectors"].empty());
}

TEST_CASE("CellsBisectorsAndTrianglesAsGlb") {
  PlaneService plane;
  const std::string target = "/voronoi?from=v:49&from=v:53&from=v:87&method=exact";
  const json numbers = plane.ask(target);
  const auto gltf = [&](const std::string& more) {
    return voronoi_gltf(plane.service.get(plane.base + target + more));
  };
  const json cells = gltf("&format=glb");
  CHECK(cells == gltf("&part=cells"));
  REQUIRE(cells["nodes"].size() == 3);
  for (int i = 0; i < 3; ++i) {
    CHECK(cells["nodes"][i]["name"] == "cell " + std::to_string(i));
    CHECK(cells["nodes"][i]["extras"]["cell"] == i);
    CHECK(cells["nodes"][i]["extras"]["cell"].is_number_integer());
    CHECK(cells["nodes"][i]["extras"]["area"] == numbers["cells"][i]["area"]);
    CHECK(cells["nodes"][i].contains("mesh"));
  }
  const json lines = gltf("&part=bisectors");
  REQUIRE(lines["nodes"].size() == 3);
  CHECK(lines["nodes"][1]["name"] == "bisector 0 2");
  CHECK(lines["nodes"][1]["extras"]["length"] == numbers["bisectors"][1]["length"]);
  CHECK(lines["meshes"][0]["primitives"][0]["mode"] == 3);
  const json dual = gltf("&part=delaunay&format=glb");
  REQUIRE(dual["nodes"].size() == 1);
  const json& primitive = dual["meshes"][0]["primitives"][0];
  CHECK(dual["accessors"][primitive["indices"].get<int>()]["count"] == 3);
  CHECK(dual["accessors"][primitive["attributes"]["POSITION"].get<int>()]["count"] == 3);
  // Two cells meet in no three.
  const json none =
      voronoi_gltf(plane.service.get(plane.base + "/voronoi?from=v:0&from=v:9&part=delaunay"));
  CHECK_FALSE(none["nodes"][0].contains("mesh"));
}

TEST_CASE("APictureOfCells") {
  PlaneService plane;
  const HttpResponse picture =
      plane.service.get(plane.base + "/voronoi?from=v:49&from=v:53&format=png&width=120&height=90");
  REQUIRE(picture.status == 200);
  CHECK(picture.content_type == "image/png");
  const HttpResponse lone =
      plane.service.get(plane.base + "/voronoi?from=v:49&format=png&width=120&height=90");
  CHECK(*picture.body != *lone.body);
  // Cells have the colours of a map.
  const HttpResponse other = plane.service.get(
      plane.base + "/voronoi?from=v:49&from=v:53&format=png&width=120&height=90&colormap=turbo");
  CHECK(*picture.body != *other.body);
}

TEST_CASE("VoronoiByGetAndPost") {
  PlaneService plane;
  plane.check_same(
      "/voronoi?from=v:7&from=f:9,0.2,0.3&relax=2&method=dijkstra&precision=7",
      R"({"from":["v:7",{"face":9,"bary":[0.2,0.3,0.5]}],"relax":2,"method":"dijkstra","precision":7})");
  plane.check_same("/voronoi?from=v:7&part=bisectors", R"({"from":"v:7","part":"bisectors"})");
}

TEST_CASE("WhatNoSiteReachesIsInNoCell") {
  PlaneService plane;
  const json reply = body_of(
      plane.service.get(plane.add(fixtures::two_components()) + "/voronoi?from=v:0&from=v:24"));
  CHECK(reply["cells"][0]["area"].get<double>() + reply["cells"][1]["area"].get<double>() ==
        doctest::Approx(16));
}

TEST_CASE("VoronoiThatIsRefused") {
  PlaneService plane;
  plane.check_refused("/voronoi", 400, "bad_syntax", "from");
  plane.check_refused("/voronoi?from=v:120", 422, "index_out_of_range", "from[0]");
  plane.check_refused("/voronoi?from=v:0&relax=x", 400, "bad_syntax", "relax");
  plane.check_refused("/voronoi?from=v:0&relax=-1", 400, "bad_syntax", "relax");
  plane.check_refused("/voronoi?from=v:0&relax=101", 413, "too_large", "relax");
  plane.check_refused("/voronoi?from=v:0&part=lines", 400, "bad_syntax", "part");
  plane.check_refused("/voronoi?from=v:0&part=cells&format=json", 406, "not_acceptable", "format");
  plane.check_refused("/voronoi?from=v:0&part=cells&format=png", 406, "not_acceptable", "format");
  plane.check_refused("/voronoi?from=v:0&format=f32", 406, "not_acceptable", "format");
  plane.check_refused("/voronoi?from=v:0&method=magic", 422, "method_unknown", "method");
  plane.check_refused("/voronoi?from=v:0&max=1", 400, "unknown_parameter", "max");
  std::string many = "/voronoi?from=v:0";
  for (int i = 0; i < 1000; ++i) many += "&from=v:0";
  plane.check_refused(many, 413, "too_large", "from");
}

TEST_CASE("ALateVoronoiEndsAtItsDeadline") {
  PlaneService plane;
  const std::string base = plane.add(shapes::icosphere(6));
  std::string target = base + "/voronoi?method=exact&relax=100&deadline_ms=50";
  for (int i = 0; i < 40; ++i) target += "&from=v:" + std::to_string(i);
  check_problem(plane.service.get(target), 504, "deadline", "");
}
