// What computations hold is counted and bounded, each and all together, and comes back.
#include "server/compute/memory.h"

#include <doctest/doctest.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <future>
#include <memory>
#include <new>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "server/base/service_codes.h"
#include "server/program/memory_limits.h"
#include "tests/fixtures/bumpy_plane.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/compute/taken_memory.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using fixtures::bumpy_plane;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("a job that wants more than one may have is refused, with what and how much") {
  ComputePool pool(1, 4);
  pool.set_memory_limits({10 * kMiB, 20 * kMiB});
  CHECK(pool.run(query_taking(9 * kMiB)) == 9 * kMiB);
  CHECK(pool.run(taking(18 * kMiB)) == 18 * kMiB);
  const auto query = pool.run(query_taking(11 * kMiB));
  REQUIRE_FALSE(query);
  CHECK(query.error().code == ServiceCode::too_much_memory);
  CHECK(query.error().limit == 10 * kMiB);
  CHECK(query.error().actual >= 11 * kMiB);
  const auto other = pool.run(taking(21 * kMiB));
  REQUIRE_FALSE(other);
  CHECK(other.error().code == ServiceCode::too_much_memory);
  CHECK(other.error().limit == 20 * kMiB);
  CHECK(pool.memory().refused == 2);
  CHECK(pool.memory().bytes == 0);
  CHECK(pool.run(query_taking(9 * kMiB)) == 9 * kMiB);
}

TEST_CASE("growth in small steps is refused as well, and a job that goes on regardless") {
  ComputePool pool(1, 4);
  pool.set_memory_limits({4 * kMiB, 200 * kMiB});
  const auto grown = pool.run([](Worker& worker) -> Result<std::size_t> {
    worker.memory->limit_to_query();
    // What comes after the refusal is let through, as far as it takes to end in order.
    std::vector<std::unique_ptr<Taken>> taken;
    taken.reserve(1000);
    for (int refusals = 0; refusals < 10;) {
      try {
        taken.push_back(std::make_unique<Taken>(100'000));
      } catch (const std::bad_alloc&) {
        CHECK(worker.memory->refusal());
        if (++refusals == 10) throw;
      }
      CHECK(worker.memory->held() < 40 * kMiB);
    }
    return taken.size();
  });
  REQUIRE_FALSE(grown);
  CHECK(grown.error().code == ServiceCode::too_much_memory);
  CHECK(pool.memory().bytes == 0);
}

TEST_CASE("a job that has no room beside others is told to come back, and later there is") {
  ComputePool pool(2, 4);
  pool.set_memory_limits({80 * kMiB, 100 * kMiB});
  std::promise<void> held;
  std::promise<void> leave;
  auto first = std::async(std::launch::async, [&] {
    return pool.run([&](Worker&) -> Result<int> {
      const Taken memory(60 * kMiB);
      held.set_value();
      leave.get_future().wait();
      return 1;
    });
  });
  held.get_future().wait();
  CHECK(pool.memory().bytes >= 59 * kMiB);
  const auto second = pool.run(query_taking(50 * kMiB));
  REQUIRE_FALSE(second);
  CHECK(second.error().code == ServiceCode::overloaded);
  CHECK(pool.run(query_taking(30 * kMiB)) == 30 * kMiB);
  leave.set_value();
  CHECK(first.get() == 1);
  CHECK(pool.run(query_taking(50 * kMiB)) == 50 * kMiB);
  CHECK(pool.memory().crowded_out == 1);
  CHECK(pool.memory().bytes == 0);
}

TEST_CASE("jobs that ask at the same moment never hold more than all may have") {
  constexpr std::size_t kJobs = 4;
  for (int round = 0; round < 100; ++round) {
    ComputePool pool(kJobs, 8);
    pool.set_memory_limits({80 * kMiB, 100 * kMiB});
    std::atomic<std::size_t> ready = 0;
    std::atomic<std::size_t> asked = 0;
    std::atomic<std::size_t> had_room = 0;
    std::vector<std::future<Result<int>>> jobs;
    for (std::size_t i = 0; i < kJobs; ++i) {
      jobs.push_back(std::async(std::launch::async, [&] {
        return pool.run([&](Worker&) -> Result<int> {
          ++ready;
          while (ready < kJobs) std::this_thread::yield();
          std::unique_ptr<Taken> taken;
          try {
            taken = std::make_unique<Taken>(40 * kMiB);
            ++had_room;
          } catch (const std::bad_alloc&) {
          }
          ++asked;
          while (asked < kJobs) std::this_thread::yield();
          return 1;
        });
      }));
    }
    for (auto& job : jobs) (void)job.get();
    REQUIRE(had_room == 2);
    REQUIRE(pool.memory().bytes == 0);
  }
}

// A sanitizer would end the program.
TEST_CASE("what the system has not is not counted" * doctest::skip(fixtures::kSanitized)) {
  ComputePool pool(1, 4);
  for (const std::uint64_t bytes : {std::uint64_t{1} << 50, std::uint64_t{1} << 61}) {
    const auto huge = pool.run([&](Worker& worker) -> Result<bool> {
      const std::unique_ptr<char[]> none(new (std::nothrow) char[bytes]);
      CHECK(worker.memory->held() < kMiB);
      return none == nullptr;
    });
    CHECK(huge == true);
  }
  CHECK(pool.memory().bytes == 0);
}

TEST_CASE("the limits follow what there is, less what others may have") {
  constexpr std::uint64_t kGiB = 1024 * kMiB;
  const Config config;
  const auto in_container = memory_limits(config, 8 * kGiB);
  CHECK(in_container.query == config.query_memory_bytes);
  CHECK(in_container.all >= 2 * in_container.query);
  CHECK(in_container.all + config.mesh_cache_bytes + config.adjacency_cache_bytes +
            config.field_cache_bytes + config.reply_cache_bytes + config.decoder_memory_bytes +
            kGiB <=
        8 * kGiB);
  CHECK(memory_limits(config, kGiB).all == kGiB / 4);
  Config given;
  given.compute_memory_bytes = 3 * kGiB;
  given.query_memory_bytes = 0;
  CHECK(memory_limits(given, kGiB).all == 3 * kGiB);

  const TemporaryFolder groups;
  const std::uint64_t machine = memory_there_is(groups.path());
  CHECK(machine > kGiB / 4);
  std::ofstream(groups.path() / "memory.max") << "max\n";
  CHECK(memory_there_is(groups.path()) == machine);
  std::ofstream(groups.path() / "memory.max") << 200 * kMiB << "\n";
  CHECK(memory_there_is(groups.path()) == 200 * kMiB);
}

TEST_CASE("a query that takes too much is 422 with the limit, and others go on") {
  Config config;
  config.query_memory_bytes = 8 * kMiB;
  config.compute_memory_bytes = 256 * kMiB;
  const TemporaryFolder folder;
  Service service(folder.path(), config);
  const std::string base = "/v1/meshes/" + service.upload(glb_of(bumpy_plane(150)));
  for (const std::string ask :
       {"/distance?from=v:0&method=exact", "/path?from=f:7,0.3,0.3&to=v:22000&method=exact",
        "/path?from=f:7,0.3,0.3&to=v:22000&method=chen_han",
        "/distance?from=v:0&method=steiner&points_per_edge=20"}) {
    CAPTURE(ask);
    const HttpResponse refused = service.get(base + ask);
    check_problem(refused, 422, "too_much_memory");
    const json problem = body_of(refused);
    CHECK(problem["limit"] == 8 * kMiB);
    CHECK(problem["actual"] > 8 * kMiB);
    CHECK(problem["detail"].get<std::string>().find("auto") != std::string::npos);
    CHECK(service.get(base + "/distance?from=v:0&method=auto").status == 200);
  }
  const json status = body_of(service.get("/v1/status"));
  CHECK(status["limits"]["query_memory_bytes"] == 8 * kMiB);
  CHECK(status["limits"]["compute_memory_bytes"] == 256 * kMiB);
  CHECK(status["compute"]["memory_bytes"] <= 64 * kMiB);
  const std::string metrics = *service.get("/metrics").body;
  CHECK(metrics.find("geodesicd_compute_memory_refusals_total{reason=\"too_much\"} 4") !=
        std::string::npos);
}

// Whatever a query is allowed, it gets the answer that it would get with all the memory there
// is, or is refused; and what it held comes back.
TEST_CASE("any budget gives the whole answer or none") {
  std::mt19937 random(fixtures::test_seed());
  const TemporaryFolder folder;
  Config config;
  config.compute_memory_bytes = 512 * kMiB;
  config.query_memory_bytes = 400 * kMiB;
  config.reply_cache_bytes = 0;
  config.field_cache_bytes = 0;
  Service service(folder.path(), config);
  const std::string base = "/v1/meshes/" + service.upload(glb_of(bumpy_plane(90)));
  const std::vector<std::string> methods{"exact",     "chen_han",      "steiner", "auto",
                                         "wavefront", "fast_marching", "dijkstra"};
  int refused = 0;
  for (int round = 0; round < fixtures::all_or(60, 12); ++round) {
    const std::string method = methods[random() % methods.size()];
    const std::string from = "from=f:" + std::to_string(random() % 1000) + ",0.2,0.3";
    const std::string to = "v:" + std::to_string(random() % 8000);
    const std::string target = base + (random() % 2 == 0 ? "/distance?" : "/path?to=" + to + "&") +
                               from + "&method=" + method;
    CAPTURE(target);
    service.pool.set_memory_limits({400 * kMiB, 512 * kMiB});
    const HttpResponse whole = service.get(target);
    REQUIRE(whole.status == 200);
    service.pool.set_memory_limits({1 + random() % (16 * kMiB), 512 * kMiB});
    const HttpResponse some = service.get(target);
    if (some.status == 200) {
      const bool is_path = target.find("/path") != std::string::npos;
      // A second question about a source is answered from a whole field.
      if (!is_path) CHECK(*some.body == *whole.body);
    } else {
      ++refused;
      check_problem(some, 422, "too_much_memory");
    }
    CHECK(service.pool.memory().bytes <= 512 * kMiB / 4);
  }
  CHECK(refused > 0);
}
