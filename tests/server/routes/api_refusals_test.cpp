// Refusals that cost little, harm nobody else, and say whether trying again is of use.
#include <doctest/doctest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "server/routes/call.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("OneMeshThatCannotBeDescribedDoesNotHideTheOthers") {
  PlaneService plane;
  // An upload that was cut off between its two files, and is no mesh for this version.
  const std::string bytes = "glTF but not really";
  const std::string id = sha256_hex(bytes);
  REQUIRE(plane.service.store->put(id, bytes, "{}"));
  REQUIRE(std::filesystem::remove(plane.folder.path() / "meta" / id.substr(0, 2) / (id + ".json")));
  check_problem(plane.service.get("/v1/meshes/" + id), 422, "mesh_invalid");
  const json page = body_of(plane.service.get("/v1/meshes"));
  REQUIRE(page["meshes"].size() == 1);
  CHECK(page["meshes"][0]["id"] == plane.id);
  REQUIRE(page["undescribed"].size() == 1);
  CHECK(page["undescribed"][0]["id"] == id);
  CHECK(page["undescribed"][0]["problem"]["code"] == "mesh_invalid");
  CHECK(page["undescribed"][0]["problem"]["status"] == 422);
  REQUIRE(plane.service.ask("DELETE", "/v1/meshes/" + id).status == 204);
  CHECK_FALSE(body_of(plane.service.get("/v1/meshes")).contains("undescribed"));
}

TEST_CASE("PointsAreCountedBeforeTheyAreTakenApart") {
  PlaneService plane;
  // The first is wrong, but it is not looked at.
  const auto body = [](const char* name, std::size_t count, const std::string& rest) {
    std::string text = std::string("{\"") + name + "\":[\"no point\"";
    for (std::size_t i = 1; i < count; ++i) text += ",\"v:0\"";
    return text + "]" + rest + "}";
  };
  const auto check = [&](const char* action, const char* name, std::size_t limit,
                         const std::string& rest) {
    CAPTURE(action);
    const HttpResponse refused =
        plane.service.ask("POST", plane.base + "/" + action, body(name, limit + 5, rest));
    check_problem(refused, 413, "too_large", name);
    CHECK(body_of(refused)["limit"] == limit);
    CHECK(body_of(refused)["actual"] == limit + 5);
  };
  check("nearest", "point", 100'000, "");
  check("distance", "from", 1000, "");
  check("distance", "at", 100'000, R"(,"from":"v:0")");
  check("table", "to", 100'000, R"(,"from":"v:0")");
  check("path", "via", 100, R"(,"from":"v:0","to":"v:1")");
  check("isolines", "levels", 10'000, R"(,"from":"v:0")");
}

TEST_CASE("ABatchHasNoMoreLinesThanTheLimit") {
  PlaneService plane;
  std::string lines;
  for (std::size_t i = 0; i < kMaxBatchLines + 1; ++i) lines += "x\n";
  const HttpResponse refused = plane.service.ask("POST", plane.base + "/batch", lines);
  check_problem(refused, 413, "too_large", "body");
  CHECK(body_of(refused)["limit"] == kMaxBatchLines);
  CHECK(body_of(plane.service.get("/v1/status"))["limits"]["max_batch_lines"] == kMaxBatchLines);
}

TEST_CASE("ABatchEndsAtItsDeadlineAndSaysSo") {
  PlaneService plane;
  std::string lines;
  for (int i = 0; i < 50'000; ++i) {
    lines += R"({"query":"distance","from":"v:)" + std::to_string(i % 120) + "\"}\n";
  }
  HttpResponse reply = plane.service.ask("POST", plane.base + "/batch?deadline_ms=100", lines);
  REQUIRE(reply.status == 200);
  REQUIRE(reply.stream);
  const auto begin = std::chrono::steady_clock::now();
  std::string chunk;
  std::string last;
  std::size_t count = 0;
  while (reply.stream(chunk)) {
    last = chunk;
    ++count;
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  CHECK(taken.count() < 20);
  CHECK(count < 50'000);
  CHECK(json::parse(last)["problem"]["code"] == "deadline");
  check_problem(plane.service.ask("POST", plane.base + "/batch?deadline_ms=0", "{}"), 422,
                "value_out_of_range", "deadline_ms");
}

// No retry makes it smaller.
TEST_CASE("AJobLargerThanAllMemoryForJobsIsRefusedForGood") {
  Config config;
  config.job_result_bytes = 100'000;
  PlaneService plane(config);
  const HttpResponse refused = plane.service.ask(
      "POST", plane.base + "/batch", std::string(200'000, ' '), {{"Prefer", "respond-async"}});
  check_problem(refused, 413, "too_large");
  CHECK(body_of(refused)["limit"] == 100'000);
  CHECK(header_of(refused, "Retry-After").empty());
}
