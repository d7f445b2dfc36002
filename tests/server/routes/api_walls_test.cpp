// Walls, which no path crosses, and the insides of lines.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/base/memory_budget.h"
#include "proto/region/read_regions.h"
#include "proto/wire/query_limits.h"
#include "server/places/walled_surface.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using fixtures::RandomMesh;
using fixtures::test_seed;

namespace {

constexpr std::size_t kVertices = 120;  // of the plane, 12 x 10

// Upright, through faces, from below the middle of the plane nearly to its upper border.
const std::string kWall = "&walls=p:5.3,1.2,0;p:5.3,8.1,0";
const double kRound = std::hypot(3.3, 3.1) + std::hypot(3.7, 3.1);  // (2, 5) to (9, 5), above

std::string point(Vec3 p) {
  return "p:" + std::to_string(p.x) + "," + std::to_string(p.y) + "," + std::to_string(p.z);
}

}  // namespace

TEST_CASE("EveryQueryGoesRoundTheEndOfAWall") {
  PlaneService plane;
  const std::string from = "from=v:62";  // (2, 5)
  const json path = plane.ask("/path?" + from + "&to=v:69&method=exact" + kWall);
  CHECK(path["length"] == doctest::Approx(kRound).epsilon(1e-12));
  // The points are on faces of the file.
  const TriangleSoup soup = shapes::plane(12, 10);
  for (const json& p : path["points"]) {
    Vec3 there{0, 0, 0};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto v = soup.faces[p["face"].get<std::size_t>()][c];
      there = there + p["bary"][c].get<double>() * soup.positions[v];
    }
    CHECK(there.x == doctest::Approx(p["xyz"][0].get<double>()));
    CHECK(there.y == doctest::Approx(p["xyz"][1].get<double>()));
  }
  const json whole = plane.ask("/distance?" + from + "&method=exact" + kWall);
  CHECK(whole["distances"].size() == kVertices);
  CHECK(whole["distances"][69] == doctest::Approx(kRound));
  CHECK(plane.ask("/distance?" + from + "&at=v:69&at=f:0,0.2,0.3&method=exact" +
                  kWall)["distances"][0] == doctest::Approx(kRound));
  CHECK(plane.ask("/table?" + from + "&to=v:69&method=exact" + kWall)["distances"][0][0] ==
        doctest::Approx(kRound));
  CHECK(plane.ask("/measure?" + from + kWall)["area"] == doctest::Approx(99));
  CHECK(plane.ask("/voronoi?from=v:62&from=v:69" + kWall)["cells"][0]["area"] ==
        doctest::Approx(5.3 * 9).epsilon(0.06));
  CHECK(plane.ask("/trace?from=v:62&direction=1,0,0&length=8" + kWall)["length"] ==
        doctest::Approx(3.3));
  CHECK(plane.ask("/loop?around=v:62&around=v:69&around=v:9" + kWall).contains("length"));
  CHECK(plane.ask("/isolines?" + from + "&count=5" + kWall)["isolines"].size() >= 5);
  CHECK(plane.ask("/logmap?" + from + "&radius=4" + kWall)["vertices"].size() > 20);
  // What lines have made is none of the file's vertices.
  const json samples = plane.ask("/samples?count=200" + kWall)["samples"];
  for (const json& sample : samples) {
    CHECK(sample["vertex"].get<std::size_t>() < kVertices);
  }
  const json diameter = plane.ask("/extent?of=diameter&fields=200&method=exact" + kWall);
  CHECK(diameter["part_vertices"] == kVertices);
  for (const json& end : diameter["vertices"]) {
    CHECK(end["vertex"].get<std::size_t>() < kVertices);
  }
  const json near = plane.ask("/nearest?point=p:5.4,3.3,2" + kWall)["points"][0];
  const json bare = plane.ask("/nearest?point=p:5.4,3.3,2")["points"][0];
  CHECK(near["face"] == bare["face"]);
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(near["bary"][c] == doctest::Approx(bare["bary"][c].get<double>()));
  }
}

TEST_CASE("MethodsGoRoundAWallTogether") {
  PlaneService plane;
  const json methods = body_of(plane.service.get("/v1/methods"))["methods"];
  for (const json& method : methods) {
    const std::string by = method["name"];
    CAPTURE(by);
    const json found = plane.ask("/distance?from=v:62&at=v:69&method=" + by + kWall);
    const double rough = by == "dijkstra" ? 0.35 : 0.06;
    CHECK(found["distances"][0] == doctest::Approx(kRound).epsilon(rough));
    const json path = plane.ask("/path?from=v:62&to=v:69&method=" + by + kWall);
    CHECK(path["length"] == doctest::Approx(kRound).epsilon(by == "dijkstra" ? 0.35 : 1e-3));
  }
}

TEST_CASE("AVertexOnAWallIsAsFarAsTheNearerOfItsSides") {
  PlaneService plane;
  // Up the sixth column of vertices, (5, 1) to (5, 8).
  const std::string wall = "&walls=v:17;v:101";
  const json found = plane.ask("/distance?from=v:62&method=exact&labels=1" + wall);
  CHECK(found["distances"][65] == doctest::Approx(3));
  CHECK(found["labels"][65] == 0);
  const json other = plane.ask("/distance?from=v:69&method=exact" + wall);
  CHECK(other["distances"][65] == doctest::Approx(4));
  CHECK(other["distances"][62] == doctest::Approx(std::hypot(3, 3) + std::hypot(4, 3)));
}

TEST_CASE("ADiscAtAWallHasTheVerticesThatTheFieldHas") {
  PlaneService plane;
  // A closed wall along edges, about the source.
  const std::string wall = "&walls=v:26;v:30;v:78;v:74;v:26";
  const std::string from = "from=v:52&method=exact" + wall;
  const json field = plane.ask("/distance?" + from);
  CHECK(field["reached"] == 25);
  for (const char* side : {"v:52", "v:0"}) {  // the first copy of a vertex is on either side
    const std::string which = "from=" + std::string(side) + "&method=exact" + wall;
    const json whole = plane.ask("/distance?" + which);
    const json measured = plane.ask("/measure?" + which + "&radii=100");
    CHECK(measured["max"] == whole["max"]);
    CHECK(measured["farthest"] == whole["farthest"]);
    CHECK(measured["discs"][0]["vertices"] == whole["reached"]);
  }
}

// Vertices of walls are in the cell that their label says.
TEST_CASE("CellsBetweenWallsHaveTheVerticesOfTheirLabels") {
  const std::uint32_t seed = test_seed();
  CAPTURE(seed);
  std::mt19937 random(seed);
  const auto below = [&](std::uint32_t count) { return random() % count; };
  const auto unit = [&] { return random() / 4294967296.0; };
  PlaneService plane;
  const auto check = [&](const std::string& query, std::uint32_t sites) {
    CAPTURE(query);
    const json labels = plane.ask("/distance" + query + "&labels=1")["labels"];
    std::vector<std::uint64_t> counts(sites);
    for (const json& label : labels) ++counts[label.get<std::size_t>()];
    const json cells = plane.ask("/voronoi" + query)["cells"];
    for (std::uint32_t i = 0; i < sites; ++i) CHECK(cells[i]["vertices"] == counts[i]);
  };
  // The wall's six vertices with two sides are nearer to the site on its right.
  check("?method=exact&from=v:61&from=v:67&walls=v:17;v:101", 2);
  for (int round = 0; round < 20; ++round) {
    CAPTURE(round);
    // From the border to the inside, so that all is reached.
    const std::uint32_t column = 1 + below(10);
    std::string query = "?method=exact&walls=v:" + std::to_string(column) +
                        ";v:" + std::to_string(column + 12 * (2 + below(7)));
    const std::uint32_t sites = 2 + below(3);
    for (std::uint32_t i = 0; i < sites; ++i) {
      query += "&from=" + point({11 * unit(), 9 * unit(), 0});
    }
    check(query, sites);
  }
}

TEST_CASE("WhatIsInsideALineIsARegion") {
  PlaneService plane;
  const std::string square = "inside:p:2.5,2.5,0;p:6.5,2.5,0;p:6.5,6.5,0;p:2.5,6.5,0";
  CHECK(plane.ask("/measure?from=v:52&method=exact&within=" + square)["area"] ==
        doctest::Approx(16));
  CHECK(plane.ask("/measure?from=v:0&method=exact&forbid=" + square)["area"] ==
        doctest::Approx(99 - 16));
  // Together with others.
  CHECK(plane.ask("/measure?from=v:0&within=" + square +
                  "&within=sphere:0,0,0,99&forbid=faces:0")["area"] == doctest::Approx(98.5));
  const std::string round = "/path?from=p:1,4.5,0&to=p:8,4.5,0&method=exact&forbid=";
  CHECK(plane.ask(round + square)["length"] ==
        doctest::Approx(2 * std::hypot(1.5, 2) + 4).epsilon(1e-9));
  plane.check_refused("/distance?from=v:52&forbid=" + square, 422, "outside_region", "from[0]");
  plane.check_refused("/distance?from=f:74,0.3,0.3&forbid=" + square, 422, "outside_region",
                      "from[0]");
  // A wall round it closes it off.
  const json closed = plane.ask(
      "/distance?from=v:52&method=exact&walls=p:2.5,2.5,0;p:6.5,2.5,0;p:6.5,6.5,0;p:2.5,6.5,0;"
      "p:2.5,2.5,0");
  CHECK(closed["reached"] == 16);
  CHECK(closed["distances"][0].is_null());
  CHECK(plane.ask("/path?from=v:52&to=v:0&walls=p:2.5,2.5,0;p:6.5,2.5,0;p:6.5,6.5,0;"
                  "p:2.5,6.5,0;p:2.5,2.5,0")["reachable"] == false);
}

TEST_CASE("WallsThatCannotBeAreRefused") {
  PlaneService plane;
  const auto refused = [&](const std::string& walls, int status, const char* code,
                           const char* parameter) {
    plane.check_refused("/distance?from=v:0&" + walls, status, code, parameter);
    plane.check_refused("/nearest?point=v:0&" + walls, status, code, parameter);
  };
  refused("walls=v:0", 422, "value_out_of_range", "walls");
  refused("walls=", 400, "bad_syntax", "walls.points[0]");
  refused("walls=v:0;", 400, "bad_syntax", "walls.points[1]");
  refused("walls=v:0;v:120", 422, "index_out_of_range", "walls.points[1]");
  refused("walls=v:0;v:1&walls=v:0;f:999,0,1", 422, "index_out_of_range", "walls[1].points[1]");
  refused("walls=v:0;ray:0,0,9,0,0,1", 422, "no_hit", "walls.points[1]");
  refused("forbid=inside:v:0;v:5", 422, "value_out_of_range", "forbid.inside");
  refused("within=inside:v:0;v:5;x", 400, "bad_syntax", "within.inside[2]");
  // There and back again goes round nothing.
  refused("within=inside:v:0;v:5;v:3", 422, "value_out_of_range", "within.inside");
  refused("walls=v:0;v:5&forbid=faces:0-197", 422, "value_out_of_range", "forbid");
  const auto refused_body = [&](const json& walls, int status, const char* code,
                                const char* parameter) {
    const json body{{"count", 1}, {"walls", walls}};
    check_problem(plane.service.ask("POST", plane.base + "/samples", body.dump()), status, code,
                  parameter);
  };
  refused_body(json::array(), 422, "value_out_of_range", "walls");
  refused_body(7, 400, "bad_syntax", "walls");
  refused_body({{"points", 7}}, 400, "bad_syntax", "walls.points");
  refused_body({{"points", {"v:0", 7}}}, 400, "bad_syntax", "walls.points[1]");
  refused_body({{"points", {"v:0", "v:1"}}, {"x", 1}}, 400, "unknown_parameter", "walls.x");
  refused_body({{"points", {"v:0", {{"vertex", 1}, {"offset", 2}}}}}, 422, "value_out_of_range",
               "walls.points[1].offset");
  refused_body({{"points", {{{"xyz", {0, 0, 5}}, {"max_snap", 1}}, "v:0"}}}, 422, "snap_too_far",
               "walls.points[0]");
  json many = json::array();
  for (std::size_t i = 0; i <= proto::kMaxWalls; ++i) many.push_back("v:0;v:1");
  refused_body(many, 413, "too_large", "walls");
  json points = json::array();
  for (std::size_t i = 0; i <= proto::kMaxLinePoints; ++i) points.push_back("v:0");
  refused_body({{"points", points}}, 413, "too_large", "walls");
  plane.check_same("/samples?count=3&walls=v:1;p:3.3,4.4,0&forbid=inside:v:70;v:72;v:94",
                   R"({"count":3,"walls":{"points":["v:1",{"xyz":[3.3,4.4,0]}]},
                       "forbid":[{"inside":[{"vertex":70},"v:72","v:94"]}]})");
}

TEST_CASE("NoWayLeadsFromOnePartOfTheSurfaceToAnother") {
  PlaneService plane;
  const std::string base = plane.add(fixtures::two_components());
  const json all = body_of(plane.service.get(base + "/samples?count=99"))["samples"];
  // The second sample is on the other part.
  const std::string there = std::to_string(all[1]["vertex"].get<int>());
  check_problem(plane.service.get(base + "/samples?count=1&walls=v:0;v:" + there), 422,
                "value_out_of_range", "walls.points[0]");
}

TEST_CASE("ASurfaceWithWallsIsPreparedOnceAndDrawn") {
  PlaneService plane;
  const auto made = [&] { return plane.service.catalog.adjacency_cache().makes; };
  plane.ask("/distance?from=v:50" + kWall);
  const std::uint64_t before = made();
  plane.ask("/distance?from=v:51" + kWall);
  CHECK(made() == before);
  plane.ask("/distance?from=v:50&walls=p:5.3,1.2,0;p:5.3,8.2,0");
  CHECK(made() == before + 1);
  // A wall of no length changes nothing.
  const auto distances = [&](const std::string& walls) {
    return plane.ask("/distance?from=v:50" + walls)["distances"];
  };
  CHECK(distances("&walls=v:7;v:7") == distances(""));
  const std::string target = plane.base + "/distance?from=v:62" + kWall + "&format=";
  CHECK(numbers_of<double>(plane.service.get(target + "f64")).size() == kVertices);
  for (const char* format : {"glb", "png", "annotated"}) {
    CAPTURE(format);
    CHECK(plane.service.get(target + format).status == 200);
  }
  const HttpResponse glb = plane.service.get(target + "glb");
  std::uint32_t length = 0;
  std::memcpy(&length, glb.body->data() + 12, sizeof length);
  const json gltf = json::parse(glb.body->substr(20, length));
  const json& primitive = gltf["meshes"][0]["primitives"][0];
  CHECK(gltf["accessors"][primitive["attributes"]["POSITION"].get<int>()]["count"] > kVertices);
  for (const std::string query :
       {"/logmap?from=v:62&format=glb", "/voronoi?from=v:62&format=glb",
        "/measure?from=v:62&format=glb", "/isolines?from=v:62&count=3&format=glb",
        "/voronoi?from=v:62&format=png", "/path?from=v:62&to=v:69&format=png",
        "/logmap?from=v:62&format=annotated"}) {
    CAPTURE(query);
    CHECK(plane.service.get(plane.base + query + kWall).status == 200);
  }
}

TEST_CASE("FindingAndCuttingLinesStopsWhenItIsToldTo") {
  const auto mesh = Mesh::build(shapes::terrain(30, 4, test_seed()));
  REQUIRE(mesh);
  const Adjacency adjacency = Adjacency::build(std::make_shared<const Mesh>(*mesh));
  auto parameters = proto::Parameters::from_query(
      {{"walls", "v:0;v:455;v:29"}, {"forbid", "inside:v:93;v:777;v:810"}});
  const auto regions = proto::read_regions(parameters);
  REQUIRE(regions);
  std::uint64_t asked = 0;
  const auto whole = cut_lines(adjacency, nullptr, *regions, {}, Cancel([&] {
                                 ++asked;
                                 return false;
                               }));
  REQUIRE(whole);
  CHECK(whole->mesh.area() < mesh->area());
  REQUIRE(asked > 10);
  for (std::uint64_t most = 0; most < asked; most += 1 + asked / 40) {
    std::uint64_t times = 0;
    const auto stopped =
        cut_lines(adjacency, nullptr, *regions, {}, Cancel([&] { return ++times > most; }));
    REQUIRE(!stopped);
    CHECK(stopped.error().code == ErrorCode::cancelled);
  }
  MemoryBudget none([](std::uint64_t) {
    return std::optional(Error{ErrorCode("too_much_memory"), "no", {}, {}, {}});
  });
  const auto refused = cut_lines(adjacency, nullptr, *regions, {}, Cancel({}, {}, &none));
  REQUIRE(!refused);
  CHECK(refused.error().code == ErrorCode("too_much_memory"));
}

// What a wall is asked memory for is asked once, however often the wall is there.
TEST_CASE("AWallThatIsThereAgainIsNoMoreWork") {
  const auto mesh = Mesh::build(shapes::terrain(30, 4, test_seed()));
  REQUIRE(mesh);
  const Adjacency adjacency = Adjacency::build(std::make_shared<const Mesh>(*mesh));
  const auto cut = [&](const proto::Regions& regions, std::uint64_t& taken) {
    MemoryBudget sum([&](std::uint64_t bytes) {
      taken += bytes;
      return std::optional<Error>();
    });
    return cut_lines(adjacency, nullptr, regions, {}, Cancel({}, {}, &sum));
  };
  auto parameters = proto::Parameters::from_query({{"walls", "v:0;v:455;v:29"}});
  auto regions = proto::read_regions(parameters);
  REQUIRE(regions);
  std::uint64_t taken_once = 0;
  const auto once = cut(*regions, taken_once);
  REQUIRE(once);
  CHECK(taken_once > 0);
  regions->walls.resize(500, proto::Wall(regions->walls[0]));
  std::uint64_t taken_often = 0;
  const auto often = cut(*regions, taken_often);
  REQUIRE(often);
  CHECK(taken_often == taken_once);
  CHECK(std::ranges::equal(often->mesh.faces(), once->mesh.faces()));
  CHECK(std::ranges::equal(often->mesh.positions(), once->mesh.positions()));
  // Another way along the same edges is another wall.
  std::reverse(regions->walls[0].points.begin(), regions->walls[0].points.end());
  std::uint64_t taken_both = 0;
  REQUIRE(cut(*regions, taken_both));
  CHECK(taken_both > taken_once);
}

// On surfaces of all kinds queries with walls succeed, and no way becomes shorter.
TEST_CASE("WallsOnRandomMeshesOnlyMakeWaysLonger") {
  const TemporaryFolder folder;
  Service service(folder.path());
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    const std::string base = "/v1/meshes/" + service.upload(glb_of(random.soup()));
    const auto spot = [&] {
      const std::uint32_t kind = random.below(3);
      if (kind == 0) return "v:" + std::to_string(random.vertex());
      if (kind == 1) return "f:" + std::to_string(random.below(random.face_count())) + ",0.2,0.3";
      return point(random.soup().positions[random.vertex()] +
                   Vec3{random.unit(), random.unit(), random.unit()});
    };
    std::string walls = "&walls=" + spot() + ";" + spot() + ";" + spot();
    if (random.unit() < 0.5) walls += "&walls=" + spot() + ";" + spot();
    CAPTURE(walls);
    const std::string from = "/distance?method=exact&from=v:" + std::to_string(random.vertex());
    const json bare = body_of(service.get(base + from))["distances"];
    const HttpResponse reply = service.get(base + from + walls);
    CAPTURE(*reply.body);
    if (reply.status == 422) {
      CHECK(body_of(reply)["code"] == "value_out_of_range");  // on another part
      continue;
    }
    REQUIRE(reply.status == 200);
    const json walled = body_of(reply)["distances"];
    REQUIRE(walled.size() == bare.size());
    for (std::size_t v = 0; v < bare.size(); ++v) {
      if (bare[v].is_null()) CHECK(walled[v].is_null());
      if (walled[v].is_null()) continue;
      const double before = bare[v];
      CHECK(walled[v].get<double>() >= before - 1e-6 * (1 + before));
    }
    for (const char* query : {"/samples?count=9", "/extent?of=diameter&fields=3"}) {
      CHECK(service.get(base + query + walls).status == 200);
    }
  }
}

// A wall over a large triangle leaves the middle of the file's face where it was.
TEST_CASE("ShapesAreByTheFacesOfTheFileThoughAWallSplitsThem") {
  PlaneService plane;
  const std::string base = plane.add({{{0, 0, 0}, {3, 0, 0}, {0, 3, 0}}, {{0, 1, 2}}});
  const std::string wall = "&walls=f:0,0.6,0.2;f:0,0.2,0.6";
  const auto ask = [&](const std::string& target) {
    const HttpResponse response = plane.service.get(base + target);
    CAPTURE(target);
    REQUIRE(response.status == 200);
    return body_of(response);
  };
  for (const std::string& more : {std::string(), wall}) {
    const json path = ask("/path?from=v:1&to=v:2&weights=5*sphere:1,1,0,0.1" + more);
    CHECK(path["cost"] == doctest::Approx(5 * std::sqrt(18)).epsilon(1e-6));
    const json distances = ask("/distance?from=sphere:1,1,0,0.1" + more)["distances"];
    CHECK(distances == json::array({0, 0, 0}));
    CHECK(ask("/distance?from=box:0.9,0.9,-1,1.1,1.1,1" + more)["distances"] == distances);
  }
}

TEST_CASE("ExtentsAreOfThePartWithMostVerticesOfTheFile") {
  PlaneService plane;
  const std::string base =
      plane.add({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 3}, {0, 3, 2}}});
  // A ring of many points, in which there are more vertices than the square has by itself.
  std::string ring;
  for (int i = 0; i <= 40; ++i) {
    const double angle = 0.15707963267948966 * (i % 40);
    ring += point({0.7 + 0.05 * std::cos(angle), 0.3 + 0.05 * std::sin(angle), 0}) + ";";
  }
  ring.pop_back();
  const json extent =
      body_of(plane.service.get(base + "/extent?of=diameter&method=exact&walls=" + ring));
  CHECK(extent["value"] == doctest::Approx(std::sqrt(2)).epsilon(0.02));
  CHECK(extent["part_vertices"] == 4);
  const json means = body_of(plane.service.get(base + "/extent?of=means&walls=" + ring))["means"];
  for (const json& mean : means) CHECK(mean > 0);
  const HttpResponse drawn = plane.service.get(base + "/extent?of=means&format=glb&walls=" + ring);
  CHECK(drawn.status == 200);
  ring.resize(ring.rfind(';'));  // an inside is closed by itself
  for (const char* of : {"diameter", "means"}) {
    check_problem(plane.service.get(base + "/extent?of=" + of + "&within=inside:" + ring), 422,
                  "value_out_of_range", "within");
  }
}
