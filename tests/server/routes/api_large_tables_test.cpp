// Tables of thousands: rows that are sent as they are done, or of which only what is near is kept.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/routes/plane_service.h"
#include "tests/server/routes/streamed_table.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using namespace std::chrono_literals;
using geodesic::fixtures::RandomMesh;
using geodesic::fixtures::test_seed;
using geodesic::fixtures::wait_until;

namespace {

std::vector<std::uint32_t> some_vertices(RandomMesh& mesh, std::size_t count) {
  std::vector<std::uint32_t> vertices(count);
  for (std::uint32_t& v : vertices) v = mesh.vertex();
  return vertices;
}

// What queries are asked of at random.
json some_method(RandomMesh& random) {
  switch (random.below(7)) {
    case 0:
      return {{"method", "wavefront"}};
    case 1:
      return {{"method", "exact"}};
    case 2:
      return {{"method", "dijkstra"}};
    case 3:
      return {{"method", "steiner"}, {"points_per_edge", 2}};
    case 4:
      return {{"method", "chen_han"}};
    case 5:
      return {{"bound", "upper"}};
    default:
      return json::object();
  }
}

}  // namespace

TEST_CASE("StreamedRowsAreTheFieldsOfDistanceBitForBit") {
  std::mt19937 seeds(test_seed());
  TableService plane;
  for (int round = 0; round < 6; ++round) {
    RandomMesh random(seeds());
    const std::string base = plane.add(random.soup());
    const auto from = some_vertices(random, 1 + random.below(12));
    const auto to = some_vertices(random, 1 + random.below(9));
    json how = some_method(random);
    if (random.unit() < 0.3) how["max"] = 3 * random.unit();
    CAPTURE(how.dump());
    const json asked = with({{"from", points_at(from)}, {"to", points_at(to)}}, how);
    const bool is_warm = random.unit() < 0.5;
    std::vector<double> expected;
    for (const std::uint32_t v : from) {
      json one = with({{"from", "v:" + std::to_string(v)}, {"format", "f64"}}, how);
      const auto field = numbers_of<double>(plane.post(base, "distance", one));
      for (const std::uint32_t at : to) expected.push_back(field.at(at));
    }
    if (!is_warm) plane.service.queries.set_cache_budget(0);
    const HttpResponse response =
        plane.post(base, "table", with(asked, {{"stream", true}, {"format", "f64"}}));
    CHECK(header_of(response, "Geo-Dtype") == "<f8");
    CHECK(header_of(response, "Geo-Shape") ==
          std::to_string(from.size()) + "," + std::to_string(to.size()));
    CHECK(header_of(response, "Geo-Rows") ==
          "0-" + std::to_string(from.size() - 1) + "/" + std::to_string(from.size()));
    CHECK(header_of(response, "Cache-Control") == "no-store");
    CHECK(numbers_in<double>(whole_stream(response)) == expected);
    plane.service.queries.set_cache_budget(std::uint64_t{1} << 30);

    const std::string floats =
        whole_stream(plane.post(base, "table", with(asked, {{"stream", true}, {"format", "f32"}})));
    const auto narrow = numbers_in<float>(floats);
    REQUIRE(narrow.size() == expected.size());
    for (std::size_t i = 0; i < narrow.size(); ++i) {
      if (how.contains("bound")) {
        CHECK(narrow[i] >= expected[i]);
      } else {
        CHECK(narrow[i] == static_cast<float>(expected[i]));
      }
    }
  }
}

TEST_CASE("StreamedNpyIsTheHeaderAndTheSameRows") {
  TableService plane;
  const std::string query = "/table?from=v:0&from=v:50&from=v:7&to=v:1&to=v:119&stream=1&format=";
  const std::string npy = whole_stream(plane.service.get(plane.base + query + "npy"));
  REQUIRE(npy.size() > 10);
  CHECK(npy.substr(0, 6) == "\x93NUMPY");
  const std::size_t header =
      10 + static_cast<unsigned char>(npy[8]) + 256u * static_cast<unsigned char>(npy[9]);
  CHECK(npy.find("'descr': '<f8'") < header);
  CHECK(npy.find("'shape': (3,2,)") < header);
  CHECK(npy.substr(header) == whole_stream(plane.service.get(plane.base + query + "f64")));
}

TEST_CASE("StreamedLinesSayWhatTheTableSays") {
  TableService plane;
  const std::string query =
      "/table?from=v:3&from=f:40,0.25,0.25&to=v:50&to=p:2,3,1&to=f:9,0.5,0.25";
  const json table = plane.ask(query + "&precision=6");
  const HttpResponse response = plane.service.get(plane.base + query + "&precision=6&stream=true");
  CHECK(response.content_type == "application/x-ndjson");
  CHECK(header_of(response, "ETag").empty());
  const auto lines = lines_in(whole_stream(response));
  REQUIRE(lines.size() == 3);
  CHECK(lines[0]["mesh"] == plane.id);
  CHECK(lines[0]["method"] == "auto");
  CHECK(lines[0]["rows"] == 2);
  CHECK(lines[0]["first_row"] == 0);
  CHECK(lines[0]["columns"] == table["columns"]);
  for (int i = 0; i < 2; ++i) {
    CHECK(lines[i + 1]["row"] == i);
    CHECK(lines[i + 1]["from"] == table["rows"][i]);
    for (int j = 0; j < 3; ++j) {
      CHECK(lines[i + 1]["distances"][j].get<double>() ==
            doctest::Approx(table["distances"][i][j].get<double>()).epsilon(1e-3));
    }
  }
}

TEST_CASE("PointsFarFromTheSurfaceAreWarnedOfBeforeTheRows") {
  TableService plane;
  const HttpResponse response =
      plane.service.get(plane.base + "/table?from=p:2,3,1000&to=v:5&stream=1");
  CHECK_FALSE(header_of(response, "Geo-Warnings").empty());
  const auto lines = lines_in(whole_stream(response));
  CHECK(lines[0]["warnings"].size() == 1);
}

TEST_CASE("ATableThatIsTakenUpAgainByRowsIsTheWholeOne") {
  std::mt19937 seeds(test_seed());
  TableService plane;
  for (int round = 0; round < 4; ++round) {
    RandomMesh random(seeds());
    const std::string base = plane.add(random.soup());
    const auto from = some_vertices(random, 2 + random.below(20));
    json asked = with({{"from", points_at(from)}, {"stream", true}}, some_method(random));
    if (random.unit() < 0.5) asked["to"] = points_at(some_vertices(random, 3));
    for (const char* format : {"f64", "ndjson"}) {
      asked["format"] = format;
      asked.erase("rows");
      const bool is_text = asked["format"] == "ndjson";
      const auto without_head = [&](std::string body) {
        return is_text ? body.substr(body.find('\n') + 1) : body;
      };
      const std::string whole = without_head(whole_stream(plane.post(base, "table", asked)));
      std::string joined;
      for (std::size_t row = 0; row < from.size();) {
        const std::size_t end =
            row + 1 + random.below(static_cast<std::uint32_t>(from.size() - row));
        const bool is_open = end == from.size() && random.unit() < 0.5;
        asked["rows"] = std::to_string(row) + "-" + (is_open ? "" : std::to_string(end - 1));
        CAPTURE(asked["rows"].dump());
        const HttpResponse part = plane.post(base, "table", asked);
        CHECK(header_of(part, "Geo-Rows") == std::to_string(row) + "-" + std::to_string(end - 1) +
                                                 "/" + std::to_string(from.size()));
        joined += without_head(whole_stream(part));
        row = end;
      }
      CHECK(joined == whole);
    }
  }
}

TEST_CASE("RowsMayBeAskedForWithoutAStream") {
  PlaneService plane;
  const json all = plane.ask("/table?from=v:0&from=v:50&from=v:7&from=v:9");
  const json some = plane.ask("/table?from=v:0&from=v:50&from=v:7&from=v:9&rows=1-2");
  CHECK(some["columns"] == all["columns"]);
  REQUIRE(some["rows"].size() == 2);
  CHECK(some["rows"][0] == all["rows"][1]);
  CHECK(some["distances"][1] == all["distances"][2]);
  plane.check_same("/table?from=v:3&from=v:100&rows=1-", R"({"from":["v:3","v:100"],"rows":"1-"})");
}

TEST_CASE("ASparseTableHasWhatTheFullOneHasWithinMax") {
  std::mt19937 seeds(test_seed());
  TableService plane;
  for (int round = 0; round < 6; ++round) {
    RandomMesh random(seeds());
    const std::string base = plane.add(random.soup());
    const auto from = some_vertices(random, 1 + random.below(12));
    const auto to = some_vertices(random, 1 + random.below(9));
    json asked = with({{"from", points_at(from)}, {"to", points_at(to)}}, some_method(random));
    if (round > 0) asked["max"] = 4 * random.unit();
    CAPTURE(asked.dump());
    const auto full = numbers_in<double>(whole_stream(
        plane.post(base, "table", with(asked, {{"stream", true}, {"format", "f64"}}))));
    const HttpResponse response = plane.post(base, "table", with(asked, {{"sparse", true}}));
    const json sparse = body_of(response);
    CHECK(sparse["rows"].size() == from.size());
    CHECK(sparse["columns"].size() == to.size());
    CHECK_FALSE(sparse.contains("distances"));
    REQUIRE(sparse["indptr"].size() == from.size() + 1);
    CHECK(sparse["indptr"][0] == 0);
    std::vector<double> filled(full.size(), kNowhere);
    for (std::size_t i = 0; i < from.size(); ++i) {
      const std::size_t end = sparse["indptr"][i + 1];
      for (std::size_t k = sparse["indptr"][i]; k < end; ++k) {
        const std::size_t j = sparse["indices"][k];
        REQUIRE(j < to.size());
        CHECK(filled[i * to.size() + j] == kNowhere);  // each once
        filled[i * to.size() + j] = sparse["data"][k];
      }
    }
    const bool has_short_digits = !asked.contains("method") && !asked.contains("bound");
    for (std::size_t i = 0; i < full.size(); ++i) {
      CHECK((has_short_digits ? static_cast<float>(filled[i]) == static_cast<float>(full[i])
                              : filled[i] == full[i]));
    }
    const auto lines = lines_in(
        whole_stream(plane.post(base, "table", with(asked, {{"sparse", true}, {"stream", true}}))));
    REQUIRE(lines.size() == from.size() + 1);
    json columns = json::array();
    json distances = json::array();
    for (std::size_t i = 0; i < from.size(); ++i) {
      CHECK(lines[i + 1]["columns"].size() == lines[i + 1]["distances"].size());
      for (const json& j : lines[i + 1]["columns"]) columns.push_back(j);
      for (const json& d : lines[i + 1]["distances"]) distances.push_back(d);
    }
    CHECK(columns == sparse["indices"]);
    CHECK(distances == sparse["data"]);
  }
}

TEST_CASE("ASparseTableIsAnsweredAlikeAndTagged") {
  PlaneService plane;
  const std::string query =
      "/table?from=v:0&from=v:50&to=v:1&to=v:51&to=v:119&max=2&sparse=1&format=";
  for (const std::string format : {"json", "frame", "npz"}) {
    CAPTURE(format);
    const HttpResponse first = plane.service.get(plane.base + query + format);
    const HttpResponse again = plane.service.get(plane.base + query + format);
    REQUIRE(first.status == 200);
    CHECK(*first.body == *again.body);
    const std::string tag = header_of(first, "ETag");
    CHECK(tag.starts_with('"'));
    const HttpResponse known =
        plane.service.ask("GET", plane.base + query + format, {}, {{"If-None-Match", tag}});
    CHECK(known.status == 304);
  }
  const HttpResponse npz = plane.service.get(plane.base + query + "npz");
  CHECK(npz.content_type == "application/x-npz");
  CHECK(header_of(npz, "Geo-Shape") == "2,3");
  CHECK(npz.body->starts_with("PK\x03\x04"));
  for (const char* name : {"data.npy", "indices.npy", "indptr.npy", "shape.npy", "format.npy"}) {
    CHECK(npz.body->find(name) != std::string::npos);
  }
}

TEST_CASE("LargeTablesThatAreRefused") {
  TableService plane;
  plane.check_refused("/table?from=v:0&stream=maybe", 400, "bad_syntax", "stream");
  plane.check_refused("/table?from=v:0&sparse=2", 400, "bad_syntax", "sparse");
  for (const char* rows : {"", "x", "-", "1", "1-x", "-1", "1--2", " 0-0", "0-0 ", "0-1-2",
                           "99999999999999999999-", "0x0-0"}) {
    CAPTURE(rows);
    check_problem(plane.post(plane.base, "table", {{"from", "v:0"}, {"rows", rows}}), 400,
                  "bad_syntax", "rows");
  }
  for (const char* rows :
       {"1-", "0-2", "1-0", "2-2", "18446744073709551615-", "0-18446744073709551615"}) {
    CAPTURE(rows);
    const json two{{"from", {"v:0", "v:1"}}, {"rows", rows}};
    const HttpResponse response = plane.post(plane.base, "table", two);
    if (std::string(rows) == "1-") {
      CHECK(response.status == 200);
      continue;
    }
    check_problem(response, 422, "value_out_of_range", "rows");
    CHECK(body_of(response)["limit"] == 1);
  }
  plane.check_refused("/table?from=v:0&stream=1&format=json", 406, "not_acceptable", "format");
  plane.check_refused("/table?from=v:0&stream=1&format=frame", 406, "not_acceptable", "format");
  plane.check_refused("/table?from=v:0&stream=1&sparse=1&format=f64", 406, "not_acceptable",
                      "format");
  plane.check_refused("/table?from=v:0&format=npz", 406, "not_acceptable", "format");
  plane.check_refused("/table?from=v:0&format=ndjson", 406, "not_acceptable", "format");
  plane.check_refused("/table?from=v:0&sparse=1&format=npy", 406, "not_acceptable", "format");
  plane.check_refused("/table?from=v:0&stream=1&to=v:120", 422, "index_out_of_range", "to[0]");
  plane.check_refused("/distance?from=v:0&stream=1", 400, "unknown_parameter", "stream");

  const auto many = [](std::size_t count) { return json(std::vector<std::string>(count, "v:0")); };
  const auto too_large = [&](const json& body, std::string_view parameter, std::uint64_t limit) {
    const HttpResponse response = plane.post(plane.base, "table", body);
    check_problem(response, 413, "too_large", parameter);
    CHECK(body_of(response)["limit"] == limit);
  };
  too_large({{"from", many(1001)}, {"to", "v:1"}}, "from", 1000);
  too_large({{"from", many(1002)}, {"to", "v:1"}, {"rows", "1-1001"}}, "from", 1000);
  too_large({{"from", many(100'001)}, {"to", "v:1"}, {"stream", true}}, "from", 100'000);
  too_large({{"from", many(40'000)}, {"stream", true}}, "to", 1'000'000'000);
  too_large({{"from", many(40'000)}, {"sparse", true}}, "to", 1'000'000'000);
  CHECK(plane.post(plane.base, "table", {{"from", many(1002)}, {"to", "v:1"}, {"rows", "2-1001"}})
            .status == 200);
  too_large({{"from", many(4500)}, {"sparse", true}, {"format", "npz"}}, "max", 20'000'000);
  CHECK(plane.is_idle());
}

TEST_CASE("AStreamIsNoLineOfABatch") {
  PlaneService plane;
  const HttpResponse response =
      plane.service.ask("POST", plane.base + "/batch",
                        "{\"query\":\"table\",\"from\":\"v:0\",\"stream\":true}\n"
                        "{\"query\":\"table\",\"from\":[\"v:0\",\"v:1\"],\"sparse\":true}\n");
  const auto lines = lines_in(whole_stream(response));
  REQUIRE(lines.size() == 2);
  CHECK(lines[0]["status"] == 406);
  CHECK(lines[0]["problem"]["parameter"] == "stream");
  CHECK(lines[1]["reply"]["data"].size() == 4);
}

TEST_CASE("ARowThatIsNotTakenHoldsNoSlot") {
  TableService plane;
  std::vector<std::uint32_t> all(120 * 20);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i % 120);
  const json asked{{"from", points_at(all)}, {"stream", true}, {"format", "f64"}};
  const std::uint64_t before = plane.service.pool.stats().finished;
  HttpResponse response = plane.post(plane.base, "table", asked);
  std::string chunk;
  REQUIRE(response.stream(chunk));
  std::uint64_t finished = 0;
  // What is computed ahead comes to its end, and then nothing is.
  wait_until([&] {
    const std::uint64_t now = plane.service.pool.stats().finished;
    const bool rests = plane.is_idle() && now == finished;
    finished = now;
    if (!rests) std::this_thread::sleep_for(20ms);
    return rests;
  });
  CHECK(finished - before < all.size() / 4);
  // The slots are there for others meanwhile, and the rest comes once it is asked for.
  CHECK(plane.ask("/distance?from=v:5")["reached"] == 120);
  std::size_t bytes = chunk.size();
  while (response.stream(chunk)) bytes += chunk.size();
  CHECK(bytes == all.size() * all.size() * sizeof(double));
  const auto held = [&] {
    return body_of(plane.service.get("/v1/status"))["replies"]["bytes"].get<std::uint64_t>();
  };
  CHECK(held() > 0);
  response = {};
  CHECK(held() == 0);
}

TEST_CASE("AStreamEndsSoonAfterItsClientIsGone") {
  TableService plane;
  const std::string base = plane.add(shapes::terrain(150, 10, 7));
  HttpRequest request =
      table_request(base, {{"from", far_apart(2000)}, {"method", "exact"}, {"stream", true}});
  std::atomic<bool> is_gone{false};
  request.caller.gone = [&] { return is_gone.load(); };
  HttpResponse response = plane.service.routes.answer(request);
  REQUIRE(response.status == 200);
  std::string chunk;
  REQUIRE(response.stream(chunk));
  wait_until([&] { return plane.service.pool.stats().running > 0; });
  is_gone = true;
  // Though nobody asks for another row.
  wait_until([&] { return plane.is_idle(); });
  CHECK_FALSE(response.stream(chunk));
  REQUIRE(response.broken);
  REQUIRE(*response.broken);
  CHECK((*response.broken)->code == ErrorCode::cancelled);
}

TEST_CASE("ADeadlineBreaksAStreamOff") {
  TableService plane;
  const std::string base = plane.add(shapes::terrain(150, 10, 7));
  json asked{{"from", far_apart(2000)}, {"method", "exact"}, {"stream", true}};
  // Before the first row it is an answer of its own.
  asked["deadline_ms"] = 1;
  check_problem(plane.post(base, "table", asked), 504, "deadline");
  asked["method"] = "dijkstra";
  asked["deadline_ms"] = 1500;
  const auto begun = std::chrono::steady_clock::now();
  const HttpResponse response = plane.post(base, "table", asked);
  if (response.status == 504) return;  // a machine that stands still
  std::string chunk;
  REQUIRE(response.stream(chunk));
  // Few rows are computed ahead, so that most are missing then.
  std::this_thread::sleep_until(begun + 1600ms);
  const auto [body, error] = received(response);
  REQUIRE(error);
  CHECK(error->code == ServiceCode::deadline);
  CHECK((chunk + body).ends_with('\n'));  // whole rows, that can be gone on from
  wait_until([&] { return plane.is_idle(); });
}

TEST_CASE("RowsInFlightAreAskedOfTheMemoryForReplies") {
  Config config;
  config.reply_memory_bytes = 200'000;
  TableService plane(config);
  const json wide{
      {"from", {"v:0", "v:1"}}, {"to", std::vector<std::string>(20'000, "v:3")}, {"format", "f64"}};
  check_problem(plane.post(plane.base, "table", with(wide, {{"stream", true}})), 422,
                "too_much_memory");
  check_problem(
      plane.post(plane.base, "table",
                 {{"from", wide["from"]}, {"to", wide["to"]}, {"sparse", true}, {"format", "npz"}}),
      422, "too_much_memory");
  CHECK(
      plane.post(plane.base, "table", {{"from", "v:0"}, {"to", "v:1"}, {"stream", true}}).status ==
      200);
}

TEST_CASE("AJobHasTheWholeStream") {
  TableService plane;
  json asked{{"from", {"v:0", "v:50", "v:119"}}, {"stream", true}, {"format", "npy"}};
  const std::string expected = whole_stream(plane.post(plane.base, "table", asked));
  const auto result_of = [&](const json& body) {
    const HttpResponse begun = plane.service.ask("POST", plane.base + "/table", body.dump(),
                                                 {{"Prefer", "respond-async"}});
    REQUIRE(begun.status == 202);
    const std::string place = header_of(begun, "Location");
    json job;
    wait_until([&] {
      job = body_of(plane.service.get(place));
      return !job["finished"].is_null();
    });
    CHECK(job["progress"] == (job["state"] == "done" ? 1 : job["progress"].get<double>()));
    return plane.service.get(place + "/result");
  };
  const HttpResponse done = result_of(asked);
  REQUIRE(done.status == 200);
  CHECK(*done.body == expected);
  CHECK(done.content_type == "application/x-npy");
  CHECK(header_of(done, "Geo-Shape") == "3,3");
  // It keeps the bytes alone, not what they came from.
  CHECK(body_of(plane.service.get("/v1/status"))["replies"]["bytes"] == 0);
  // One that is broken off has no result.
  const std::string base = plane.add(shapes::terrain(150, 10, 7));
  asked = {{"from", far_apart(2000)}, {"method", "exact"}, {"stream", true}, {"deadline_ms", 500}};
  const HttpResponse begun =
      plane.service.ask("POST", base + "/table", asked.dump(), {{"Prefer", "respond-async"}});
  const std::string place = header_of(begun, "Location");
  json job;
  wait_until([&] {
    job = body_of(plane.service.get(place));
    return !job["finished"].is_null();
  });
  CHECK(job["state"] == "failed");
  check_problem(plane.service.get(place + "/result"), 504, "deadline");
}
