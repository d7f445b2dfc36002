// Many queries in one request.
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

std::vector<json> lines_of(const HttpResponse& response) {
  REQUIRE(response.status == 200);
  CHECK(response.content_type == "application/x-ndjson");
  REQUIRE(response.stream);
  std::vector<json> lines;
  std::string chunk;
  while (response.stream(chunk)) {
    REQUIRE(chunk.ends_with('\n'));
    CHECK(chunk.find('\n') == chunk.size() - 1);
    lines.push_back(json::parse(chunk));
    chunk.clear();
  }
  return lines;
}

}  // namespace

TEST_CASE("EachLineIsAnsweredLikeTheRequestItStandsFor") {
  PlaneService plane;
  const std::string body =
      R"({"id":1,"query":"path","from":"v:0","to":"v:119"}
{"id":"second","query":"distance","from":["v:0","v:9"],"at":"v:50"}

{"query":"table","from":["v:0","v:9"],"precision":4}
{"id":4,"query":"nearest","point":"p:1,2,3"})";
  const auto lines = lines_of(plane.service.ask("POST", plane.base + "/batch", body));
  REQUIRE(lines.size() == 4);
  CHECK(lines[0]["id"] == 1);
  CHECK(lines[0]["reply"] == plane.ask("/path?from=v:0&to=v:119"));
  CHECK(lines[1]["id"] == "second");
  CHECK(lines[1]["reply"] == plane.ask("/distance?from=v:0&from=v:9&at=v:50"));
  CHECK_FALSE(lines[2].contains("id"));
  CHECK(lines[2]["reply"] == plane.ask("/table?from=v:0&from=v:9&precision=4"));
  CHECK(lines[3]["reply"] == plane.ask("/nearest?point=p:1,2,3"));
  for (const json& line : lines) CHECK(line["status"] == 200);
}

TEST_CASE("ALineThatIsWrongHarmsNoOther") {
  PlaneService plane;
  const std::string deep(200'000, '[');
  const std::string body =
      "{\"id\":1,\"query\":\"path\",\"from\":\"v:0\",\"to\":\"v:1\"}\n"
      "not json\n"
      "[1,2]\n"
      "{\"id\":4,\"query\":\"path\",\"from\":" +
      deep +
      "\n"
      "{\"id\":5}\n"
      "{\"id\":6,\"query\":\"batch\"}\n"
      "{\"id\":[7,8],\"query\":\"path\",\"from\":\"v:0\",\"to\":\"v:1\"}\n"
      "{\"id\":8,\"query\":\"path\",\"from\":\"v:0\",\"to\":\"v:999\"}\n"
      "{\"id\":9,\"query\":\"distance\",\"from\":\"v:0\",\"format\":\"png\"}\n"
      "{\"id\":10,\"query\":\"distance\",\"from\":\"v:0\",\"colour\":1}\n"
      "{\"id\":\"\xff\",\"query\":\"distance\"}\n"
      "{\"id\":12,\"query\":\"path\",\"from\":\"v:0\",\"to\":\"v:1\"}\n";
  const auto lines = lines_of(plane.service.ask("POST", plane.base + "/batch", body));
  REQUIRE(lines.size() == 12);
  const std::vector<int> statuses{200, 400, 400, 400, 400, 400, 400, 422, 406, 400, 400, 200};
  for (std::size_t i = 0; i < lines.size(); ++i) {
    CAPTURE(i);
    CHECK(lines[i]["status"] == statuses[i]);
    if (statuses[i] == 200) continue;
    CHECK(lines[i]["problem"]["status"] == statuses[i]);
    CHECK(lines[i]["problem"]["request_id"] == "test");
  }
  CHECK(lines[4]["id"] == 5);
  CHECK(lines[4]["problem"]["parameter"] == "query");
  CHECK(lines[7]["problem"]["code"] == "index_out_of_range");
  CHECK(lines[7]["problem"]["parameter"] == "to");
  CHECK(lines[9]["problem"]["code"] == "unknown_parameter");
}

TEST_CASE("ALineThatAsksForADrawingIsRefused") {
  PlaneService plane;
  const auto lines =
      lines_of(plane.service.ask("POST", plane.base + "/batch",
                                 R"({"query":"voronoi","from":["v:0","v:9"],"part":"cells"}
{"query":"voronoi","from":["v:0","v:9"]})"));
  REQUIRE(lines.size() == 2);
  CHECK(lines[0]["status"] == 406);
  CHECK(lines[0]["problem"]["code"] == "not_acceptable");
  CHECK(lines[0]["problem"]["parameter"] == "part");
  CHECK(lines[1]["status"] == 200);
}

TEST_CASE("ALineThatNamesAParameterTwiceIsRefused") {
  PlaneService plane;
  const auto lines =
      lines_of(plane.service.ask("POST", plane.base + "/batch",
                                 R"({"query":"path","from":"v:0","to":"v:1","to":"v:2"}
{"query":"path","from":"v:0","to":{"vertex":1,"vertex":2}})"));
  REQUIRE(lines.size() == 2);
  for (const json& line : lines) {
    CHECK(line["status"] == 400);
    CHECK(line["problem"]["code"] == "bad_syntax");
  }
  CHECK(lines[0]["problem"]["parameter"] == "to");
  CHECK(lines[1]["problem"]["parameter"] == "vertex");
}

TEST_CASE("ABatchIsRefusedAsAWholeWhereItCanBe") {
  PlaneService plane;
  check_problem(plane.service.ask("POST", plane.base + "/batch?x=1", "{}"), 400,
                "unknown_parameter", "x");
  check_problem(plane.service.ask("GET", plane.base + "/batch"), 405, "method_not_allowed");
  check_problem(plane.service.ask("POST", "/v1/meshes/" + std::string(64, '0') + "/batch", "{}"),
                404, "mesh_unknown");
  CHECK(lines_of(plane.service.ask("POST", plane.base + "/batch", "\n \n")).empty());
}

TEST_CASE("ABatchMayHaveAsManyLinesAsItSaysHoweverTheyEnd") {
  PlaneService plane;
  const auto most = body_of(plane.service.get("/v1/status"))["limits"]["max_batch_lines"];
  const auto lines = [](std::size_t count, const std::string& between) {
    std::string body;
    for (std::size_t i = 0; i < count; ++i) body += "{}" + between;
    return body;
  };
  const auto status = [&](const std::string& body) {
    return plane.service.ask("POST", plane.base + "/batch", body).status;
  };
  for (const std::string between : {"\n", "\r\n", "\n\n \t\n"}) {
    CAPTURE(between);
    for (const std::string end : {"", "\n", "\n\n\n"}) {
      CHECK(status(lines(most, between) + end) == 200);
      CHECK(status(lines(most, between).substr(0, lines(most, between).size() - 1) + end) == 200);
      CHECK(status(lines(most, between) + "{}" + end) == 413);
    }
  }
}

TEST_CASE("ALinesMemoryIsHeldUntilTheNextIsAskedFor") {
  Config config;
  config.reply_memory_bytes = 4'000'000;
  config.reply_cache_bytes = 0;
  PlaneService plane(config);
  const std::string base = plane.add(shapes::plane(200, 200));
  const auto held = [&] {
    return body_of(plane.service.get("/v1/status"))["replies"]["bytes"].get<std::uint64_t>();
  };
  const std::string lines =
      "{\"query\":\"distance\",\"from\":\"v:0\"}\n{\"query\":\"distance\",\"from\":\"v:1\"}\n";
  const auto next = [](const HttpResponse& reply) {
    std::string chunk;
    REQUIRE(reply.stream(chunk));
    return chunk;
  };
  // Clients that take nothing: what they have not taken is all that is made for them.
  std::vector<HttpResponse> waiting;
  std::uint64_t made = 0;
  json refused;
  while (waiting.size() < 20 && refused.is_null()) {
    waiting.push_back(plane.service.ask("POST", base + "/batch", lines));
    REQUIRE(waiting.back().stream);
    const std::string chunk = next(waiting.back());
    const json line = json::parse(chunk);
    if (line["status"] == 200) {
      made += chunk.size();
    } else {
      refused = line["problem"];
    }
  }
  REQUIRE(refused.is_object());
  CHECK((refused["code"] == "overloaded" || refused["code"] == "too_many_requests"));
  CHECK(made <= config.reply_memory_bytes);
  CHECK(held() + 1000 * waiting.size() >= made);
  // Who takes what was made for it gets the next.
  CHECK(json::parse(next(waiting.front()))["status"] == 200);
  waiting.clear();
  CHECK(held() == 0);
}
