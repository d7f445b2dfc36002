// Tables whose columns are curves, boundaries and faces.
#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/routes/line_tables.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::RandomMesh;
using geodesic::fixtures::test_seed;
using geodesic::fixtures::wait_until;

namespace {

bool is_line(const json& source) {
  const std::string text = source;
  return text.starts_with("curve") || text.starts_with("boundary") || text.starts_with("faces");
}

// Rows that there are on this mesh: curves may be between two pieces.
json some_rows(LineTables& plane, const std::string& base, RandomMesh& random, int count) {
  json rows = json::array();
  for (int i = 0; i < count; ++i) {
    const std::string row = some_row(random);
    const json alone{{"from", row}, {"to", "v:0"}, {"method", "dijkstra"}};
    if (plane.table(base, alone).status == 200) rows.push_back(row);
  }
  return rows;
}

}  // namespace

TEST_CASE("ALineAsAColumnIsItsFieldAtTheRows") {
  LineTables plane;
  with_random_meshes(plane, test_seed(), 8, [&](RandomMesh& random, const std::string& base) {
    json asked = some_method(random);
    if (random.unit() < 0.4) asked["max"] = 4 * random.unit();
    const json to = some_rows(plane, base, random, 6);
    json from = json::array();
    for (int i = 0; i < 8; ++i)
      from.push_back(i % 3 < 2 ? some_vertex(random) : some_place(random));
    if (to.empty()) return;
    asked["from"] = from;
    asked["to"] = to;
    CAPTURE(asked.dump());
    const std::vector<double> table = plane.streamed(base, asked);
    for (std::size_t j = 0; j < to.size(); ++j) {
      if (!is_line(to[j])) continue;
      CAPTURE(to[j].dump());
      for (std::size_t i = 0; i < from.size(); ++i) {
        json field = asked;
        field.erase("to");
        field["from"] = to[j];
        field["at"] = from[i];
        field["format"] = "f64";  // JSON has a float's digits where it is one
        const HttpResponse found = plane.service.ask("POST", base + "/distance", field.dump());
        REQUIRE(found.status == 200);
        CHECK(table[i * to.size() + j] == numbers_in<double>(*found.body).at(0));
      }
    }
  });
}

// By all methods, from both ends, in every form, and whatever else is asked.
TEST_CASE("DistancesOfLinesAreTheSameWhoeverAsks") {
  LineTables plane;
  with_random_meshes(plane, test_seed() + 1, 8, [&](RandomMesh& random, const std::string& base) {
    json asked = some_method(random);
    if (random.unit() < 0.4) asked["max"] = 4 * random.unit();
    json from = some_rows(plane, base, random, 8);
    if (from.empty()) return;
    from.push_back(from[0]);
    const std::size_t n = from.size();
    asked["from"] = from;
    CAPTURE(asked.dump());
    json bytes = asked;
    bytes["format"] = "f64";
    const auto whole = numbers_of<double>(plane.table(base, bytes));
    REQUIRE(whole.size() == n * n);
    const std::vector<double> rows = plane.streamed(base, asked);
    const json told = body_of(plane.table(base, asked));
    CHECK(told["rows"] == told["columns"]);
    json sparse = asked;
    sparse["sparse"] = true;
    const json near = body_of(plane.table(base, sparse));
    for (std::size_t i = 0; i < n; ++i) {
      // Each row alone, and each entry alone.
      json alone = asked;
      alone["rows"] = std::to_string(i) + "-" + std::to_string(i);
      const std::vector<double> row = plane.streamed(base, alone);
      std::size_t entry = near["indptr"][i];
      for (std::size_t j = 0; j < n; ++j) {
        const double here = whole[i * n + j];
        const bool is_in = entry < near["indptr"][i + 1].get<std::size_t>() &&
                           near["indices"][entry].get<std::size_t>() == j;
        if (is_in) ++entry;
        if (!is_line(from[j])) continue;
        CAPTURE(i);
        CAPTURE(j);
        CHECK(rows[i * n + j] == here);
        CHECK(row[j] == here);
        CHECK(is_in == (here < kNowhere));
        json one = asked;
        one["from"] = from[i];
        one["to"] = from[j];
        CHECK(plane.streamed(base, one) == std::vector<double>{here});
        if (is_line(from[i])) {
          CHECK(whole[j * n + i] == here);
        }
        if (from[i] == from[j]) CHECK(here == 0);
      }
    }
  });
}

// Lines cross, touch, lie within faces, and faces within faces.
TEST_CASE("LinesInAPlaneAreAsNearAsTheyLook") {
  PlaneService plane;  // 12 x 10 vertices
  const std::vector<std::string> lines{
      "boundary",                       // x = 0 and 11, y = 0 and 9
      "curve:v:49;v:56",                // y = 4, x from 1 to 8
      "curve:v:28;v:100",               // x = 4, y from 2 to 8
      "box:6.1,5.1,-1,9.9,7.9,1",       // faces of x from 6 to 10, y from 5 to 8
      "box:7.1,6.1,-1,8.9,6.9,1",       // of x from 7 to 9, y from 6 to 7
      "curve:p:10.2,1.5,0;p:10.7,1,0",  // within two faces
      "curve:p:7.4,6.3,0;p:8.1,6.7,0",  // within both boxes
      "curve:v:0;v:0",                  // a point
      "p:2.5,7.25,0",
  };
  std::string query = "/table?method=exact";
  for (const std::string& line : lines) query += "&from=" + line;
  const double aside = 4.48 / std::hypot(0.7, 0.4);  // of (10.2, 1.5) from the curve in the boxes
  const auto within = [](double x, double y) { return std::hypot(x, y); };
  const double wanted[9][9] = {
      {0, 1, 1, 1, 2, 0.3, 2.3, 0, 1.75},
      {1, 0, 0, 1, 2, within(2.2, 2.5), 2.3, within(1, 4), 3.25},
      {1, 0, 0, 2, 3, within(6.2, 0.5), 3.4, within(4, 2), 1.5},
      {1, 1, 2, 0, 0, within(0.2, 3.5), 0, within(6, 5), 3.5},
      {2, 2, 3, 0, 0, within(1.2, 4.5), 0, within(7, 6), within(4.5, 0.25)},
      {0.3, within(2.2, 2.5), within(6.2, 0.5), within(0.2, 3.5), within(1.2, 4.5), 0, aside,
       within(10.2, 1.5), within(7.7, 5.75)},
      {2.3, 2.3, 3.4, 0, 0, aside, 0, within(7.4, 6.3), within(4.9, 0.95)},
      {0, within(1, 4), within(4, 2), within(6, 5), within(7, 6), within(10.2, 1.5),
       within(7.4, 6.3), 0, within(2.5, 7.25)},
      {1.75, 3.25, 1.5, 3.5, within(4.5, 0.25), within(7.7, 5.75), within(4.9, 0.95),
       within(2.5, 7.25), 0},
  };
  const json reply = plane.ask(query);
  for (std::size_t i = 0; i < 9; ++i) {
    for (std::size_t j = 0; j < 9; ++j) {
      CAPTURE(i);
      CAPTURE(j);
      const double found = reply["distances"][i][j];
      CHECK(std::abs(found - wanted[i][j]) < 1e-9);
    }
  }
  CHECK(reply["columns"][0]["kind"] == "boundary");
  CHECK(reply["columns"][3]["faces"] == 24);
  plane.check_same(
      "/table?from=v:0&to=boundary:0&to=curve:v:49;v:56&to=faces:7&to=v:3&method=exact",
      R"({"from":"v:0","to":[{"boundary":0},{"curve":{"points":["v:49",{"vertex":56}]}},)"
      R"({"faces":[7]},"v:3"],"method":"exact"})");
}

TEST_CASE("EdgesOfACube") {
  TriangleSoup cube;
  for (int v = 0; v < 8; ++v)
    cube.positions.push_back({double(v & 1), double(v >> 1 & 1), double(v >> 2)});
  const int sides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& s : sides) {
    cube.faces.push_back({std::uint32_t(s[0]), std::uint32_t(s[1]), std::uint32_t(s[2])});
    cube.faces.push_back({std::uint32_t(s[0]), std::uint32_t(s[2]), std::uint32_t(s[3])});
  }
  PlaneService plane;
  const std::string base = plane.add(cube);
  // Along x at the bottom in front, at the bottom behind, at the top behind; all of the right side;
  // within the left one.
  const json reply = body_of(plane.service.get(
      base +
      "/table?method=exact&from=curve:v:0;v:1&from=curve:v:2;v:3&from=curve:v:6;v:7&from="
      "box:0.9,0,0,1.1,1,1&from=curve:p:0,0.25,0.5;p:0,0.75,0.5"));
  const double aside = std::hypot(0.25, 0.5);
  const double across = std::sqrt(2);
  const double wanted[5][5] = {{0, 1, across, 0, aside},
                               {1, 0, 1, 0, aside},
                               {across, 1, 0, 0, aside},
                               {0, 0, 0, 0, 1.25},
                               {aside, aside, aside, 1.25, 0}};
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t j = 0; j < 5; ++j) {
      CAPTURE(i);
      CAPTURE(j);
      CHECK(std::abs(reply["distances"][i][j].get<double>() - wanted[i][j]) < 1e-9);
    }
  }
}

TEST_CASE("ColumnsOfLinesAskForTheirMemory") {
  Config config;
  config.query_memory_bytes = 4 << 20;
  PlaneService plane(config);
  const std::string base = plane.add(shapes::terrain(150, 10, 7));
  for (const std::string form : {"", "&stream=1", "&sparse=1&max=9"}) {
    CAPTURE(form);
    check_problem(
        plane.service.get(base + "/table?from=v:7&to=boundary&to=v:9&method=exact" + form), 422,
        "too_much_memory");
  }
}

TEST_CASE("EntriesOfLineColumnsAreAskedOfTheMemoryForRepliesBeforeTheyAreComputed") {
  Config config;
  config.reply_memory_bytes = 200'000;
  LineTables plane(config);
  const std::vector<std::string> from(300, "v:3");
  CHECK(plane.table(plane.base, {{"from", from}, {"to", {"boundary"}}, {"stream", true}}).status ==
        200);
  const std::uint64_t finished = plane.service.pool.stats().finished;
  for (const char* form : {"stream", "sparse"}) {
    const json asked{
        {"from", from}, {"to", std::vector<std::string>(100, "boundary")}, {form, true}};
    check_problem(plane.table(plane.base, asked), 422, "too_much_memory");
  }
  CHECK(plane.service.pool.stats().finished == finished);
}

TEST_CASE("ATableOfLineColumnsEndsSoonAfterItsClientIsGone") {
  LineTables plane;
  const std::string base = plane.add(shapes::terrain(150, 10, 7));
  json lines = json::array();
  for (int i = 0; i < 400; ++i) {
    lines.push_back("faces:" + std::to_string(i * 50) + "-" + std::to_string(i * 50 + 40));
  }
  HttpRequest request =
      table_request(base, {{"from", lines}, {"method", "exact"}, {"stream", true}});
  std::atomic<int> asked{0};
  request.caller.gone = [&] { return ++asked > 200; };
  CHECK(plane.service.routes.answer(request).status != 200);
  wait_until([&] { return plane.service.pool.stats().running == 0; });
  CHECK(plane.ask("/distance?from=v:5")["reached"] == 120);
}
