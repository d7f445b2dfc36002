// Large replies ask for their memory before they are made; the bytes of a mesh take none.
#include <doctest/doctest.h>

#include <cstdint>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "server/base/service_codes.h"
#include "server/http/reply_budget.h"
#include "tests/server/http/gunzipped.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

Config with_reply_memory(std::uint64_t bytes) {
  Config config;
  config.reply_memory_bytes = bytes;
  config.reply_cache_bytes = 0;
  return config;
}

json replies_of(PlaneService& plane) { return body_of(plane.service.get("/v1/status"))["replies"]; }

// So many balls, each of which has all faces of a plane of 100 x 100 vertices.
json balls_of_all_faces(int count) {
  json balls = json::array();
  for (int i = 0; i < count; ++i) balls.push_back("sphere:0,0,0," + std::to_string(1000 + i));
  return balls;
}

}  // namespace

TEST_CASE("AReplyBudgetIsSharedAndGivenBack") {
  ReplyBudget budget(100);
  auto first = budget.reserve(70, "ann");
  REQUIRE(first);
  const auto second = budget.reserve(40, "bob");
  REQUIRE_FALSE(second);
  CHECK(second.error().code == ServiceCode::overloaded);  // another time it may fit
  const auto never = budget.reserve(101, "bob");
  REQUIRE_FALSE(never);
  CHECK(never.error().code == ServiceCode::too_much_memory);
  CHECK(never.error().limit == 100);
  CHECK(never.error().actual == 101);
  (*first)->shrink(60);
  CHECK(budget.reserve(40, "bob"));
  CHECK(budget.stats().bytes == 60);
  first->reset();
  CHECK(budget.stats().bytes == 0);
  CHECK(budget.stats().refused == 2);
  std::shared_ptr<ReplyBudget::Share> survivor;
  {
    ReplyBudget gone(10);
    survivor = *gone.reserve(5, "ann");
  }
  survivor.reset();
}

TEST_CASE("OneClientCannotHoldAllMemoryForReplies") {
  ReplyBudget budget(100);
  std::vector<std::shared_ptr<ReplyBudget::Share>> held;
  const auto take_all = [&](const std::string& client) {
    while (true) {
      auto share = budget.reserve(5, client);
      if (!share) return share.error().code;
      held.push_back(std::move(*share));
    }
  };
  CHECK(take_all("ann") == ServiceCode::too_many_requests);
  CHECK(budget.stats().bytes == 50);
  CHECK(take_all("bob") == ServiceCode::too_many_requests);
  CHECK(budget.stats().bytes == 75);
  CHECK(budget.reserve(5, "eve"));
  held.clear();
  CHECK(budget.stats().bytes == 0);
  // Alone, a client may have all of it at once; and it follows a new configuration.
  CHECK(budget.reserve(100, "ann"));
  budget.set_budget(20);
  CHECK(budget.reserve(21, "ann").error().code == ServiceCode::too_much_memory);
  CHECK(budget.reserve(20, "ann"));
}

TEST_CASE("PartsOfAShareAreAskedForTogetherAndGivenBackApart") {
  ReplyBudget budget(100);
  const auto share = budget.share_of_nothing("ann");
  auto first = ReplyBudget::take_part(share, 40);
  REQUIRE(first);
  auto second = ReplyBudget::take_part(share, 50);  // it is alone, so it may have all
  REQUIRE(second);
  CHECK(budget.stats().bytes == 90);
  const auto never = ReplyBudget::take_part(share, 20);
  REQUIRE_FALSE(never);
  CHECK(never.error().code == ServiceCode::too_much_memory);
  CHECK(budget.reserve(20, "bob").error().code == ServiceCode::overloaded);
  first->reset();
  CHECK(budget.stats().bytes == 50);
  CHECK(ReplyBudget::take_part(share, 20));
  CHECK(budget.stats().bytes == 50);  // nobody has kept it
  second->reset();
  CHECK(budget.stats().bytes == 0);
}

TEST_CASE("LinesOfATableAreAskedOfTheMemoryForRepliesUntilTheirEntriesAreThere") {
  PlaneService plane(with_reply_memory(500'000));
  const std::string base = plane.add(shapes::plane(100, 100));
  constexpr std::uint64_t kBytesOfBall = 2 * 99 * 99 * sizeof(std::uint32_t);
  for (const std::string form : {"", "stream", "sparse"}) {
    CAPTURE(form);
    const auto table = [&](const json& from) {
      json asked{{"from", from}, {"max", 1}};
      if (!form.empty()) asked[form] = true;
      return plane.service.ask("POST", base + "/table", asked.dump());
    };
    const HttpResponse refused = table(balls_of_all_faces(10));
    check_problem(refused, 422, "too_much_memory");
    CHECK(body_of(refused)["limit"] == 500'000);
    CHECK(body_of(refused)["actual"] > 10 * kBytesOfBall);
    CHECK(body_of(refused)["actual"] < 11 * kBytesOfBall);
    CHECK(replies_of(plane)["bytes"] == 0);
    if (form != "sparse") {  // whose first entry asks for more than all of this
      // What they were needed for is over before the first row is sent.
      const HttpResponse fits = table(balls_of_all_faces(3));
      CHECK(fits.status == 200);
      CHECK(replies_of(plane)["bytes"] < kBytesOfBall);
    }
    CHECK(replies_of(plane)["bytes"] == 0);
  }
}

TEST_CASE("LinesThatAQueryStartsFromCountAsLongAsItHoldsThem") {
  const TriangleSoup strip = shapes::plane(1000, 4);
  constexpr std::uint64_t kEdges = 2 * (999 + 3);  // of the boundary
  {
    PlaneService small(with_reply_memory(200'000));
    const std::string base = small.add(strip);
    for (const char* query : {"/distance?from=boundary&at=v:7", "/isolines?from=boundary&levels=1",
                              "/table?from=boundary&to=v:7", "/table?from=v:7&to=boundary",
                              "/table?from=boundary&to=v:7&stream=1"}) {
      CAPTURE(query);
      check_problem(small.service.get(base + query), 422, "too_much_memory");
    }
    // What is as small as most counts nowhere.
    CHECK(small.service.get(base + "/distance?from=curve:v:0;v:7&at=v:9").status == 200);
    CHECK(replies_of(small)["bytes"] == 0);
  }
  PlaneService plane(with_reply_memory(400'000));
  const std::string base = plane.add(strip);
  HttpResponse stream = plane.service.get(base + "/table?from=boundary&to=v:7&to=v:9&stream=1");
  REQUIRE(stream.status == 200);
  CHECK(replies_of(plane)["bytes"] > 100 * kEdges);
  for (const char* query : {"/distance?from=boundary&at=v:7", "/table?from=v:7&to=boundary"}) {
    CAPTURE(query);
    const HttpResponse refused = plane.service.get(base + query);
    check_problem(refused, 503, "overloaded");
    CHECK_FALSE(header_of(refused, "Retry-After").empty());
  }
  stream = {};
  CHECK(replies_of(plane)["bytes"] == 0);
  CHECK(plane.service.get(base + "/distance?from=boundary&at=v:7").status == 200);
  CHECK(replies_of(plane)["bytes"] == 0);
}

TEST_CASE("AReplyThatNeverFitsIsRefusedForGoodAndNamesTheLimit") {
  PlaneService plane(with_reply_memory(1'000'000));
  const std::string base = plane.add(shapes::plane(200, 150));
  const HttpResponse refused = plane.service.get(base + "/distance?from=v:0");
  check_problem(refused, 422, "too_much_memory");
  CHECK(body_of(refused)["limit"] == 1'000'000);
  CHECK(body_of(refused)["actual"] > 1'000'000);
  CHECK(header_of(refused, "Retry-After").empty());
  // In binary, as the detail says, it does.
  CHECK(plane.service.get(base + "/distance?from=v:0&format=f32").status == 200);
  CHECK(plane.service.get(base + "/distance?from=v:0&at=v:7").status == 200);
  CHECK(replies_of(plane)["refused"] == 1);
}

TEST_CASE("WhatUnsentRepliesHaveTakenIsHadLater") {
  PlaneService plane(with_reply_memory(4'000'000));
  const std::string base = plane.add(shapes::plane(200, 200));
  // As long as it is not sent, a reply keeps its memory.
  std::vector<HttpResponse> unsent;
  HttpResponse last;
  for (int i = 0; i < 20; ++i) {
    last = plane.service.get(base + "/distance?method=wavefront&from=v:" + std::to_string(i));
    if (last.status != 200) break;
    CHECK(last.reserved);
    unsent.push_back(std::move(last));
  }
  REQUIRE(last.status == 429);  // the client has half of it
  CHECK(body_of(last)["code"] == "too_many_requests");
  CHECK_FALSE(header_of(last, "Retry-After").empty());
  const std::uint64_t taken = replies_of(plane)["bytes"];
  CHECK(taken > 600'000 * unsent.size());
  CHECK(taken <= 2'000'000);
  unsent.clear();
  CHECK(replies_of(plane)["bytes"] == 0);
  CHECK(plane.service.get(base + "/distance?from=v:1").status == 200);
}

TEST_CASE("LargeRepliesAreEncodedAndPackedInAComputeSlot") {
  PlaneService plane(with_reply_memory(100'000'000));
  const std::string base = plane.add(shapes::plane(200, 200));
  const auto target = base + "/distance?from=v:0";
  const std::string plain = *plane.service.get(target).body;
  for (const char* method : {"GET", "POST"}) {
    const auto before = plane.service.pool.stats().finished;
    const HttpResponse packed =
        std::string(method) == "GET"
            ? plane.service.ask("GET", target, {}, {{"Accept-Encoding", "gzip"}})
            : plane.service.ask("POST", base + "/distance", R"({"from":"v:0"})",
                                {{"Accept-Encoding", "gzip"}});
    CHECK(plane.service.pool.stats().finished == before + 1);  // the field is there
    CHECK(header_of(packed, "Content-Encoding") == "gzip");
    CHECK(gunzipped(*packed.body) == plain);
    // It does not keep the room of what it was packed from.
    CHECK(packed.body->capacity() < packed.body->size() + 1000);
  }
}

TEST_CASE("TheBytesOfAMeshAreSentFromTheirFile") {
  PlaneService plane(with_reply_memory(1000));
  const std::string bytes = glb_of(shapes::plane(12, 10));
  const HttpResponse source = plane.service.get(plane.base + "/source");
  REQUIRE(source.status == 200);
  CHECK(source.file);
  CHECK(*source.body == bytes);
  CHECK(header_of(source, "ETag") == "\"" + plane.id + "\"");
  CHECK(replies_of(plane)["bytes"] == 0);
  // What is being sent stays whole, whatever becomes of the mesh.
  REQUIRE(plane.service.ask("DELETE", plane.base).status == 204);
  std::string piece(100, '\0');
  CHECK(source.file->read(50, piece.data(), piece.size()) == 100);
  CHECK(piece == bytes.substr(50, 100));
  CHECK(plane.service
            .ask("GET", plane.base + "/source", {}, {{"If-None-Match", header_of(source, "ETag")}})
            .status == 404);
}

TEST_CASE("DamagedBytesAreNotSentThoughTheyWereWholeBefore") {
  PlaneService plane;
  REQUIRE(plane.service.get(plane.base + "/source").status == 200);
  const auto path = plane.folder.path() / "objects" / plane.id.substr(0, 2) / plane.id;
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(100);
    file.put('\x7f');
    file.put('\x01');
  }
  check_problem(plane.service.get(plane.base + "/source"), 500, "store_corrupt");
  CHECK(plane.service.get(plane.base + "/source").status == 404);
}

TEST_CASE("WhoTakeTheSameGeometryAtOnceShareIt") {
  PlaneService plane;
  for (const std::string format : {"glb", "frame"}) {
    const std::string target = plane.base + "/geometry?format=" + format;
    const HttpResponse first = plane.service.get(target);
    const HttpResponse second = plane.service.get(target);
    REQUIRE(first.status == 200);
    CHECK(first.body == second.body);
    CHECK(first.reserved);
    const std::string tag = header_of(first, "ETag");
    CHECK(tag.starts_with("\""));
    CHECK(plane.service.ask("GET", target, {}, {{"If-None-Match", tag}}).status == 304);
  }
  CHECK(replies_of(plane)["bytes"] == 0);
}
