// Large replies ask for their memory before they are made; the bytes of a mesh take none.
#include <doctest/doctest.h>

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
