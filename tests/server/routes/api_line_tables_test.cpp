// Tables whose rows are curves, boundaries and faces.
#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
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

// Tables are asked before fields: these would be kept.
TEST_CASE("ARowOfALineIsItsFieldAtTheColumnsToTheLastBit") {
  LineTables plane;
  with_random_meshes(plane, test_seed(), 8, [&](RandomMesh& random, const std::string& base) {
    json asked = some_method(random);
    json to = json::array();
    std::vector<std::uint32_t> columns;
    for (int i = 0; i < 12; ++i) {
      columns.push_back(random.vertex());
      to.push_back("v:" + std::to_string(columns.back()));
    }
    if (random.unit() < 0.4) asked["max"] = 4 * random.unit();
    json from = json::array();
    for (int i = 0; i < 9; ++i) {
      const std::string row = some_row(random);
      json alone = asked;
      alone["from"] = row;
      alone["to"] = "v:0";
      if (plane.table(base, alone).status == 200) from.push_back(row);
    }
    if (from.empty()) return;
    asked["from"] = from;
    asked["to"] = to;
    CAPTURE(asked.dump());
    const std::vector<double> rows = plane.streamed(base, asked);
    json bytes = asked;
    bytes["format"] = "f64";
    const auto whole = numbers_of<double>(plane.table(base, bytes));
    json sparse = asked;
    sparse["sparse"] = true;
    sparse["method"] = asked.value("method", "auto");
    const json near = body_of(plane.table(base, sparse));
    REQUIRE(rows.size() == from.size() * to.size());
    REQUIRE(whole.size() == rows.size());
    REQUIRE(near["indptr"].size() == from.size() + 1);
    for (std::size_t i = 0; i < from.size(); ++i) {
      CAPTURE(from[i].dump());
      json field = asked;
      field.erase("to");
      field["from"] = from[i];
      field["format"] = "f64";
      const HttpResponse response = plane.service.ask("POST", base + "/distance", field.dump());
      REQUIRE(response.status == 200);
      const auto distances = numbers_of<double>(response);
      const std::string text = from[i];
      const bool is_line = text[0] != 'v' && text[0] != 'f' ? true : text.starts_with("faces");
      std::size_t reached = 0;
      for (std::size_t j = 0; j < columns.size(); ++j) {
        const double wanted = distances[columns[j]];
        CHECK(rows[i * columns.size() + j] == wanted);
        if (is_line) CHECK(whole[i * columns.size() + j] == wanted);
        reached += wanted < kNowhere ? 1 : 0;
      }
      CHECK(near["indptr"][i + 1].get<std::size_t>() - near["indptr"][i].get<std::size_t>() ==
            reached);
    }
  });
}

TEST_CASE("RowsOfLinesAtPointsInsideFaces") {
  LineTables plane;
  with_random_meshes(plane, test_seed(), 6, [&](RandomMesh& random, const std::string& base) {
    json to = json::array();
    for (int i = 0; i < 6; ++i) to.push_back(in_some_face(random));
    for (int i = 0; i < 4; ++i) {
      const json asked{{"from", some_row(random)}, {"to", to}, {"method", "exact"}};
      CAPTURE(asked.dump());
      const HttpResponse response = plane.table(base, asked);
      if (response.status != 200) continue;
      const auto streamed = plane.streamed(base, asked);
      const json row = body_of(response)["distances"][0];
      const json field = body_of(
          plane.service.ask("POST", base + "/distance",
                            json{{"from", asked["from"]}, {"at", to}, {"method", "exact"}}.dump()));
      for (std::size_t j = 0; j < to.size(); ++j) {
        const json& wanted = field["distances"][j];
        CHECK(row[j].is_null() == wanted.is_null());
        CHECK((streamed[j] == kNowhere) == wanted.is_null());
        if (wanted.is_null()) continue;
        const double slack = 1e-9 * (1 + wanted.get<double>());
        CHECK(std::abs(row[j].get<double>() - wanted.get<double>()) <= slack);
        CHECK(std::abs(streamed[j] - wanted.get<double>()) <= slack);
      }
    }
  });
}

// Boundary of the plane, a curve from (1, 4) to (8, 4), faces with x from 2 to 5 and y from 2 to 6.
TEST_CASE("ATableOfLinesSaysWhatItsRowsAre") {
  PlaneService plane;
  const std::string query =
      "/table?from=boundary&from=curve:v:49;v:56&from=v:0&from=box:2,2,-1,5,6,1&to=v:65&to=p:4.2,"
      "6.5,0&method=exact";
  const json reply = plane.ask(query);
  CHECK(reply["rows"][0]["kind"] == "boundary");
  CHECK(reply["rows"][0]["length"] == 40);
  CHECK(reply["rows"][1]["kind"] == "curve");
  CHECK(reply["rows"][1]["pieces"] == 7);
  CHECK(reply["rows"][2]["vertex"] == 0);
  CHECK_FALSE(reply["rows"][2].contains("kind"));
  CHECK(reply["rows"][3]["faces"] == 24);
  CHECK(reply["columns"].size() == 2);
  const double wanted[4][2] = {{4, 2.5}, {1, 2.5}, {std::sqrt(50), std::hypot(4.2, 6.5)}, {0, 0.5}};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 2; ++j) {
      CHECK(std::abs(reply["distances"][i][j].get<double>() - wanted[i][j]) < 1e-9);
    }
  }
  plane.check_same(
      "/table?from=boundary:0&from=curve:v:49;v:56&from=faces:7&to=v:65&method=exact",
      R"({"from":[{"boundary":0},{"curve":{"points":["v:49",{"vertex":56}]}},{"faces":[7]}],)"
      R"("to":"v:65","method":"exact"})");
  // Row by row, and taken up again.
  const auto lines = lines_in(whole_stream(plane.service.get(plane.base + query + "&stream=1")));
  REQUIRE(lines.size() == 5);
  for (int i = 0; i < 4; ++i) {
    CHECK(lines[i + 1]["from"] == reply["rows"][i]);
    const json rest = plane.ask(query + "&rows=" + std::to_string(i) + "-");
    CHECK(rest["rows"][0] == reply["rows"][i]);
    CHECK(rest["distances"][0] == reply["distances"][i]);
  }
  const json sparse = plane.ask(query + "&sparse=1&max=3");
  CHECK(sparse["indptr"] == json::array({0, 1, 3, 3, 5}));
  CHECK(sparse["indices"] == json::array({1, 0, 1, 0, 1}));
}

TEST_CASE("LineTablesThatAreRefused") {
  PlaneService plane;
  for (const std::string line : {"boundary", "boundary:0", "curve:v:1;v:7", "faces:1", "part:0"}) {
    for (const std::string form : {"", "&stream=1", "&sparse=1"}) {
      plane.check_refused("/table?to=v:1&slope=tobler&from=" + line + form, 422,
                          "value_out_of_range", "from[0]");
      plane.check_refused("/table?from=v:1&weights=2*faces:3&to=v:2&to=" + line + form, 422,
                          "value_out_of_range", "to[1]");
    }
  }
  for (const std::string form : {"", "&stream=1", "&sparse=1"}) {
    const std::string query = "/table?to=v:1&from=v:0" + form;
    plane.check_refused(query + "&from=boundary:1", 422, "index_out_of_range", "from[1]");
    plane.check_refused(query + "&from=part:7", 422, "index_out_of_range", "from[1].part");
    plane.check_refused(query + "&from=curve:v:1", 422, "value_out_of_range", "from[1]");
    plane.check_refused(query + "&from=curve:v:1;v:500", 422, "index_out_of_range",
                        "from[1].points[1]");
    plane.check_refused(query + "&from=box:50,50,50,51,51,51", 422, "value_out_of_range",
                        "from[1]");
    plane.check_refused(query + "&to=boundary:1", 422, "index_out_of_range", "to[1]");
    plane.check_refused(query + "&to=material:glass", 422, "value_out_of_range", "to[1].material");
    plane.check_refused(query + "&to=box:50,50,50,51,51,51", 422, "value_out_of_range", "to[1]");
  }
  check_problem(
      plane.service.ask(
          "POST", plane.base + "/table",
          R"({"from":[{"curve":{"points":["v:1",{"vertex":2,"offset":1}]}}],"to":"v:1"})"),
      422, "value_out_of_range", "from[0].curve.points[1].offset");
  std::string half = "&from=curve:v:0";
  for (int i = 0; i < 500; ++i) half += ";v:1";
  plane.check_refused("/table?to=v:0" + half + half, 413, "too_large", "from");
  for (std::size_t at = half.find("from"); at != half.npos; at = half.find("from")) {
    half.replace(at, 4, "to");
  }
  plane.check_refused("/table?from=v:0" + half + half, 413, "too_large", "to");
  json many{{"from", json::array()}, {"to", json::array()}, {"stream", true}};
  for (int i = 0; i < 20'001; ++i) many["from"].push_back("v:0");
  for (int i = 0; i < 500; ++i) many["to"].push_back("boundary");
  check_problem(plane.service.ask("POST", plane.base + "/table", many.dump()), 413, "too_large",
                "to");
  json wide{{"from", "v:0"}, {"to", json::array()}};
  for (int i = 0; i < 1001; ++i) wide["to"].push_back("boundary");
  check_problem(plane.service.ask("POST", plane.base + "/table", wide.dump()), 413, "too_large",
                "to");
  const std::string ball = plane.add(shapes::icosphere(1));
  check_problem(plane.service.get(ball + "/table?from=v:0&from=boundary&to=v:1"), 422,
                "value_out_of_range", "from[1]");
}

// They are found once, and a boundary is kept once.
TEST_CASE("TheSameBoundaryInAThousandRows") {
  PlaneService plane;
  std::string many = "/table?method=exact&to=v:65&to=v:0";
  for (int i = 0; i < 500; ++i) many += "&from=boundary&from=faces:0";
  const json all = plane.ask(many);
  REQUIRE(all["distances"].size() == 1000);
  for (int i = 0; i < 1000; i += 2) {
    CHECK(all["distances"][i] == all["distances"][0]);
    CHECK(all["rows"][i] == all["rows"][0]);
    CHECK(all["distances"][i + 1] == all["distances"][1]);
  }
}

TEST_CASE("RowsOfLinesAskForTheirMemory") {
  Config config;
  config.query_memory_bytes = 4 << 20;
  PlaneService plane(config);
  const std::string base = plane.add(shapes::terrain(150, 10, 7));
  for (const std::string form : {"", "&stream=1", "&sparse=1&max=9"}) {
    CAPTURE(form);
    const HttpResponse response =
        plane.service.get(base + "/table?from=v:7&from=boundary&to=v:9&method=exact" + form);
    // The first row of a stream may be there before the second one is refused.
    if (response.stream) {
      std::string chunk;
      while (response.stream(chunk)) chunk.clear();
      REQUIRE(*response.broken);
      CHECK((*response.broken)->code == ServiceCode::too_much_memory);
    } else {
      check_problem(response, 422, "too_much_memory");
    }
  }
}

TEST_CASE("ATableOfLinesEndsSoonAfterItsClientIsGone") {
  LineTables plane;
  const std::string base = plane.add(shapes::terrain(150, 10, 7));
  for (const bool is_stream : {false, true}) {
    CAPTURE(is_stream);
    json from = json::array();
    for (int i = 0; i < 800; ++i) {
      from.push_back("faces:" + std::to_string(i * 50) + "-" + std::to_string(i * 50 + 40));
    }
    HttpRequest request = table_request(
        base, {{"from", from}, {"to", "v:3"}, {"method", "exact"}, {"stream", is_stream}});
    std::atomic<int> asked{0};
    request.caller.gone = [&] { return ++asked > 200; };
    HttpResponse response = plane.service.routes.answer(request);
    std::string chunk;
    while (response.stream && response.stream(chunk)) chunk.clear();
    if (response.stream) {
      REQUIRE(*response.broken);
      CHECK((*response.broken)->code == ErrorCode::cancelled);
    } else {
      CHECK(response.status != 200);
    }
    wait_until([&] { return plane.service.pool.stats().running == 0; });
    CHECK(plane.ask("/distance?from=v:5")["reached"] == 120);
  }
}
