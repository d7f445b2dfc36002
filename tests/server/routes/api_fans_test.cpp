// Edges and vertices of very many faces: what is asked there takes its time and its memory in a
// compute slot, where both are bounded.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "server/compute/memory.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

constexpr double kTurn = 2 * 3.14159265358979323846;

// Triangles on the edge from (0, 0, 0) to (0, 0, 1), whose third corners are at height 1/2, one
// away.
TriangleSoup faces_on_one_edge(std::uint32_t count) {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {0, 0, 1}};
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = kTurn * i / count;
    soup.positions.push_back({std::cos(angle), std::sin(angle), 0.5});
    soup.faces.push_back({0, 1, i + 2});
  }
  return soup;
}

// A disc of so many faces on one vertex, and a last face without area: the edge from
// that vertex to the last of the rim.
TriangleSoup faces_at_one_vertex(std::uint32_t count) {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}};
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = kTurn * i / count;
    soup.positions.push_back({std::cos(angle), std::sin(angle), 0});
    soup.faces.push_back({0, 1 + i, 1 + (i + 1) % count});
  }
  soup.faces.push_back({0, 0, count});
  return soup;
}

struct Columns {
  json points = json::array();
  std::vector<double> heights;
};

// Points of the common edge, each named by another of its faces.
Columns columns_on_the_edge(std::size_t count, std::uint32_t faces) {
  std::mt19937 random(fixtures::test_seed());
  std::uniform_real_distribution<double> height(0.01, 0.99);
  Columns columns;
  for (std::size_t i = 0; i < count; ++i) {
    const double z = height(random);
    columns.heights.push_back(z);
    columns.points.push_back({{"face", random() % faces}, {"bary", {1 - z, z, 0}}});
  }
  return columns;
}

}  // namespace

TEST_CASE("ATableToPointsOfAnEdgeOfManyFacesTakesNoMemoryOutsideOfASlot") {
  constexpr std::uint32_t kFaces = 4000;
  PlaneService plane;
  const std::string base = plane.add(faces_on_one_edge(kFaces));
  const Columns columns = columns_on_the_edge(500, kFaces);
  const std::string body = json{{"from", "v:2"}, {"to", columns.points}}.dump();
  REQUIRE(plane.service.get(base + "/distance?from=v:3&at=v:4").status == 200);  // prepares
  HttpResponse reply;
  {
    // Of this thread, which is in the place of a connection's.
    ComputeMemory all;
    all.set_limits({0, std::uint64_t{8} << 20});
    const JobMemory here(all, 0);
    REQUIRE_NOTHROW(reply = plane.service.ask("POST", base + "/table", body));
  }
  REQUIRE(reply.status == 200);
  const json distances = body_of(reply)["distances"][0];
  REQUIRE(distances.size() == columns.heights.size());
  for (std::size_t i = 0; i < distances.size(); ++i) {
    // Straight across the first face.
    CHECK(distances[i].get<double>() ==
          doctest::Approx(std::hypot(1, columns.heights[i] - 0.5)).epsilon(1e-9));
  }
}

TEST_CASE("TheMemoryOfATablesTargetsIsThatOfTheQuery") {
  constexpr std::uint32_t kFaces = 100'000;
  Config config;
  config.query_memory_bytes = 1'000'000;
  config.compute_memory_bytes = 1'000'000'000;
  PlaneService plane(config);
  const std::string base = plane.add(faces_on_one_edge(kFaces));
  const json body{{"from", "v:2"}, {"to", columns_on_the_edge(4, kFaces).points}};
  check_problem(plane.service.ask("POST", base + "/table", body.dump()), 422, "too_much_memory");
}

TEST_CASE("ATableToAnEdgeOfManyFacesEndsAtItsDeadline") {
  constexpr std::uint32_t kFaces = 20'000;
  PlaneService plane;
  const std::string base = plane.add(faces_on_one_edge(kFaces));
  REQUIRE(plane.service.get(base + "/distance?from=v:3&at=v:4").status == 200);
  for (const int deadline_ms : {5, 30, 100}) {
    CAPTURE(deadline_ms);
    const json body{{"from", "v:2"},
                    {"to", columns_on_the_edge(2000, kFaces).points},
                    {"deadline_ms", deadline_ms}};
    check_problem(plane.service.ask("POST", base + "/table", body.dump()), 504, "deadline");
  }
}

TEST_CASE("PointsOfADroppedFaceAtAVertexOfManyFacesAreFoundInASlot") {
  constexpr std::uint32_t kFaces = 30'000;
  PlaneService plane;
  const std::string base = plane.add(faces_at_one_vertex(kFaces));
  REQUIRE(plane.service.get(base + "/nearest?point=v:0").status == 200);
  const auto before = plane.service.pool.stats().finished;
  const json found = body_of(plane.service.get(base + "/nearest?point=f:30000,0.3,0.3"))["points"];
  CHECK(plane.service.pool.stats().finished == before + 1);
  CHECK(found[0]["xyz"][0].get<double>() ==
        doctest::Approx(0.4 * std::cos(kTurn * (kFaces - 1) / kFaces)));
  const json many(10'000, "f:30000,0.3,0.3");
  check_problem(plane.service.ask("POST", base + "/nearest",
                                  json{{"point", many}, {"deadline_ms", 100}}.dump()),
                504, "deadline");
}
