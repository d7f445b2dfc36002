// Many clients at once: what is expensive is made once, and every reply is the same.
#include <doctest/doctest.h>

#include <atomic>
#include <barrier>
#include <chrono>
#include <future>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/fixtures/wait_until.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

constexpr int kClients = 64;

// Runs `work(i)` on kClients threads that start together.
template <class Work>
void all_at_once(Work work) {
  std::barrier start(kClients);
  std::vector<std::thread> clients;
  for (int i = 0; i < kClients; ++i) {
    clients.emplace_back([&, i] {
      start.arrive_and_wait();
      work(i);
    });
  }
  for (std::thread& client : clients) client.join();
}

}  // namespace

TEST_CASE("SixtyFourClientsOnAFreshMeshPrepareItOnce") {
  const TemporaryFolder folder;
  std::string id;
  {
    Service service(folder.path());
    id = service.upload(glb_of(shapes::terrain(60, 5, 3)));
  }
  Service service(folder.path());  // knows the mesh, has nothing prepared
  for (const std::string query :
       {"/distance?from=v:7&format=f64", "/path?from=v:7&to=v:3000", "/nearest?point=p:9,9,9"}) {
    std::vector<std::string> replies(kClients);
    std::vector<int> statuses(kClients);
    all_at_once([&](int i) {
      const HttpResponse response = service.get("/v1/meshes/" + id + query);
      statuses[static_cast<std::size_t>(i)] = response.status;
      replies[static_cast<std::size_t>(i)] = *response.body;
    });
    for (const int status : statuses) CHECK(status == 200);
    for (const std::string& reply : replies) CHECK(reply == replies.front());
  }
  CHECK(service.catalog.mesh_cache().makes == 1);
  CHECK(service.catalog.adjacency_cache().makes == 2);  // the adjacency, the closest points
  CHECK(service.queries.field_cache().makes == 1);
}

TEST_CASE("SixtyFourUploadsOfOneFileDecodeItOnce") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string glb = glb_of(shapes::terrain(40, 5, 3));
  std::vector<int> statuses(kClients);
  all_at_once([&](int i) {
    statuses[static_cast<std::size_t>(i)] = service.ask("POST", "/v1/meshes", glb).status;
  });
  for (const int status : statuses) CHECK((status == 201 || status == 200));
  CHECK(service.catalog.mesh_cache().makes == 1);
  CHECK(service.store->size() == 1);
}

TEST_CASE("BudgetsSmallerThanTwoMeshesStillAnswerEverything") {
  const TemporaryFolder folder;
  Config config;
  config.mesh_cache_bytes = 200'000;
  config.adjacency_cache_bytes = 800'000;
  config.field_cache_bytes = 30'000;
  Service service(folder.path(), config);
  std::vector<std::string> ids;
  std::vector<std::string> expected;
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    ids.push_back(service.upload(glb_of(shapes::terrain(40, 5, seed))));
    expected.push_back(*service.get("/v1/meshes/" + ids.back() + "/path?from=v:0&to=v:1599").body);
  }
  const CacheStats prepared = service.catalog.adjacency_cache();
  CHECK(prepared.entries < 2);
  std::atomic<int> wrong{0};
  all_at_once([&](int i) {
    for (int round = 0; round < 3; ++round) {
      const auto which = static_cast<std::size_t>((i + round) % 4);
      const HttpResponse response =
          service.get("/v1/meshes/" + ids[which] + "/path?from=v:0&to=v:1599");
      if (response.status != 200 || *response.body != expected[which]) ++wrong;
    }
  });
  CHECK(wrong == 0);
  CHECK(service.catalog.adjacency_cache().evictions > 0);
  CHECK(service.catalog.adjacency_cache().bytes <= config.adjacency_cache_bytes);
  CHECK(service.queries.field_cache().bytes <= config.field_cache_bytes);
}

TEST_CASE("ATableHasTheSameBytesHoweverManySlotsItHas") {
  std::string query = "/table?format=f64";
  for (int i = 0; i < 12; ++i) query += "&from=v:" + std::to_string(i * 70);
  for (int i = 0; i < 7; ++i) query += "&to=f:" + std::to_string(i * 200) + ",0.25,0.5";
  for (const std::string method : {"wavefront", "auto", "exact"}) {
    CAPTURE(method);
    std::string expected;
    for (const std::size_t slots : {1, 2, 4}) {
      const TemporaryFolder folder;
      Service service(folder.path(), {}, slots);
      const std::string base = "/v1/meshes/" + service.upload(glb_of(shapes::terrain(30, 5, 3)));
      // Others ask meanwhile, so that slots come and go.
      std::atomic<bool> is_over{false};
      std::thread other([&] {
        for (int i = 0; !is_over; ++i) {
          service.get(base + "/distance?format=f32&from=v:" + std::to_string(i % 900));
        }
      });
      const HttpResponse table = service.get(base + query + "&method=" + method);
      is_over = true;
      other.join();
      REQUIRE(table.status == 200);
      if (expected.empty()) expected = *table.body;
      CHECK(*table.body == expected);
    }
  }
}

TEST_CASE("DeletingWhileOthersAskIsSafe") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string glb = glb_of(shapes::terrain(30, 5, 9));
  const std::string id = sha256_hex(glb);
  std::atomic<int> unexpected{0};
  all_at_once([&](int i) {
    for (int round = 0; round < 4; ++round) {
      int status = 0;
      if (i % 8 == 0) {
        status = service.ask("DELETE", "/v1/meshes/" + id).status;
      } else if (i % 8 < 3) {
        status = service.ask("POST", "/v1/meshes", glb).status;
      } else {
        status = service.get("/v1/meshes/" + id + "/distance?from=v:0&format=f32").status;
      }
      // A mesh may vanish between an upload and the description of what was known.
      if (status != 200 && status != 201 && status != 204 && status != 404) ++unexpected;
    }
  });
  CHECK(unexpected == 0);
  CHECK(service.ask("POST", "/v1/meshes", glb).status < 300);
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:0").status == 200);
}

TEST_CASE("WhatHadNoSlotYetGoesAheadOfNobody") {
  const TemporaryFolder folder;
  Service service(folder.path(), {}, 1);
  const std::string base = "/v1/meshes/" + service.upload(glb_of(shapes::plane(12, 10)));
  const std::string near = json{{"point", std::vector<std::string>(5000, "v:7")}}.dump();
  const std::string annotated = R"({"from": "v:7", "format": "annotated"})";
  const auto nearest = [&] { return service.ask("POST", base + "/nearest", near); };
  const auto cached = [&] { return service.ask("POST", base + "/distance", annotated); };
  CHECK(nearest().status == 200);
  CHECK(cached().status == 200);
  std::promise<void> gate;
  auto running = std::async(std::launch::async, [&] {
    return service.pool.run([&](Worker&) -> Result<int> {
      gate.get_future().wait();
      return 1;
    });
  });
  fixtures::wait_until([&] { return service.pool.stats().running == 1; });
  service.pool.set_limits({0, 0, std::chrono::milliseconds(0)});
  auto first = std::async(std::launch::async, nearest);
  auto second = std::async(std::launch::async, cached);
  // Neither waits for the slot.
  const auto is_refused = [](std::future<HttpResponse>& reply) {
    return reply.wait_for(std::chrono::seconds(30)) == std::future_status::ready;
  };
  const bool are_refused = is_refused(first) && is_refused(second);
  gate.set_value();
  CHECK(are_refused);
  CHECK(first.get().status == 503);
  CHECK(second.get().status == 503);
  CHECK(running.get());
}

TEST_CASE("WhoIsRefusedHearsHowLongTheQueueIs") {
  const TemporaryFolder folder;
  Service service(folder.path(), {}, 1);
  const std::string id = service.upload(glb_of(shapes::plane(12, 10)));
  const auto ask = [&](int vertex) {
    return service.get("/v1/meshes/" + id + "/distance?from=v:" + std::to_string(vertex));
  };
  // Jobs that are known to take a tenth of a second, and more; then a line of them.
  for (int i = 0; i < 8; ++i) {
    (void)service.pool.run([](Worker&) -> Result<int> {
      std::this_thread::sleep_for(std::chrono::milliseconds(250));
      return 1;
    });
  }
  std::shared_future<void> opened;
  std::vector<std::future<Result<int>>> line;
  std::promise<void> gate;  // last: a test that ends early lets the line go
  opened = gate.get_future().share();
  constexpr std::size_t kWaiting = 40;
  for (std::size_t i = 0; i < kWaiting + 1; ++i) {
    line.push_back(std::async(std::launch::async, [&] {
      return service.pool.run([&](Worker&) -> Result<int> {
        opened.wait();
        return 1;
      });
    }));
  }
  fixtures::wait_until([&] {
    const auto stats = service.pool.stats();
    return stats.queued == kWaiting && stats.running == 1;
  });
  const auto waits = [](const HttpResponse& refused) {
    CHECK(refused.status == 503);
    CHECK(body_of(refused)["code"] == "overloaded");
    return std::stoi(header_of(refused, "Retry-After"));
  };
  service.pool.set_limits({0, 0, std::chrono::milliseconds(0)});
  CHECK(waits(ask(1)) >= 3);
  std::set<int> spread;
  for (int i = 0; i < 100; ++i) spread.insert(waits(ask(1)));
  CHECK(*spread.rbegin() <= 2 * 60);
  CHECK(spread.size() >= 3);  // not all come back at once
  service.pool.set_limits({256, 0, std::chrono::milliseconds(1000)});
  const HttpResponse late = ask(1);
  const std::string detail = body_of(late)["detail"];
  CAPTURE(detail);
  const std::size_t about = detail.find("about ");
  REQUIRE(about != std::string::npos);
  const std::string wait = detail.substr(about + 6);
  CHECK(wait.find(" s to wait") != std::string::npos);
  CHECK(waits(late) >= std::stoi(wait));
  CHECK(waits(late) <= 2 * std::stoi(wait));
  CHECK(detail.find("1 s (--queue-seconds)") != std::string::npos);
  gate.set_value();
  for (auto& one : line) CHECK(one.get());
  CHECK(ask(1).status == 200);
}
