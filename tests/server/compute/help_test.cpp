// Jobs that idle slots help.
#include <doctest/doctest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <numeric>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/team.h"
#include "server/base/service_codes.h"
#include "server/compute/pool.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/wait_until.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace std::chrono_literals;
using geodesic::fixtures::test_seed;
using geodesic::fixtures::wait_until;

namespace {

// What a field does: many short steps, of a sum that is known.
std::uint64_t sum_in_steps(Team* team, std::uint64_t steps) {
  const Cancel cancel([] { return false; }, {}, nullptr, team);
  Poll poll(cancel);
  std::array<std::uint64_t, 5> sums{};
  for (std::uint64_t step = 0; step < steps; ++step) {
    run_parts(sums.size(), poll, [&sums, step](std::size_t part, Poll&) { sums[part] += step; });
  }
  return std::accumulate(sums.begin(), sums.end(), std::uint64_t{0});
}
std::uint64_t sum_of(std::uint64_t steps) { return 5 * (steps * (steps - 1) / 2); }

// Computes with help as long as this lives. Where other programs keep those who help from their
// cores, a computation goes on alone: then it begins another.
class JobWithHelp {
 public:
  explicit JobWithHelp(ComputePool& pool)
      : thread_([this, &pool] {
          CHECK(pool.run([&](Worker&) -> Result<int> {
            while (!is_done_) compute(pool);
            return 5;
          }) == 5);
        }) {}
  ~JobWithHelp() {
    is_done_ = true;
    thread_.join();
  }
  JobWithHelp(const JobWithHelp&) = delete;
  JobWithHelp& operator=(const JobWithHelp&) = delete;

 private:
  void compute(ComputePool& pool) {
    ComputePool::Help help(pool);
    Team* const team = help.team();
    if (team == nullptr) std::this_thread::sleep_for(1ms);
    const Cancel never;
    Poll poll(never);
    while (team != nullptr && !team->is_over() && !is_done_) {
      team->run(2, poll, [](std::size_t, Poll&) {});
    }
  }

  std::atomic<bool> is_done_{false};
  std::thread thread_;
};

}  // namespace

TEST_CASE("idle slots help a job") {
  ComputePool pool(3, 4);
  std::atomic<int> together{0};
  const auto done = pool.run([&](Worker&) -> Result<std::uint64_t> {
    ComputePool::Help help(pool);
    REQUIRE(help.team() != nullptr);
    wait_until([&] { return pool.stats().helping == 2; });
    const Cancel never;
    Poll poll(never);
    // No part ends before all three have begun.
    help.team()->run(3, poll, [&together](std::size_t, Poll&) {
      together.fetch_add(1);
      wait_until([&together] { return together == 3; });
    });
    return pool.stats().running;
  });
  CHECK(done.value() == 3);
  CHECK(together == 3);
  wait_until([&] { return pool.stats().running == 0; });
  CHECK(pool.stats().helping == 0);
}

TEST_CASE("nobody helps where no slot is idle") {
  ComputePool pool(1, 4);
  CHECK(pool.run([&](Worker&) -> Result<bool> {
    const bool has_team = ComputePool::Help(pool).team() != nullptr;
    return has_team;
  }) == false);
}

TEST_CASE("whoever helps leaves for another job at once") {
  ComputePool pool(2, 4);
  const JobWithHelp long_one(pool);
  for (int i = 0; i < 100; ++i) {
    wait_until([&] { return pool.stats().helping == 1; });
    CHECK(pool.run([](Worker&) -> Result<int> { return 7; }) == 7);
  }
}

TEST_CASE("whoever helps leaves for the parts of a table") {
  ComputePool pool(2, 4);
  const JobWithHelp long_one(pool);
  wait_until([&] { return pool.stats().helping == 1; });
  CHECK(pool.run_each(50, [](Worker&, std::size_t, const GiveWay&) -> Result<void> { return {}; },
                      {}));
}

TEST_CASE("what a part throws ends the job alone") {
  ComputePool pool(3, 4);
  const auto done = pool.run([&](Worker&) -> Result<int> {
    ComputePool::Help help(pool);
    wait_until([&] { return pool.stats().helping == 2; });
    const Cancel never;
    Poll poll(never);
    help.team()->run(3, poll, [](std::size_t part, Poll&) {
      if (part == 2) throw std::bad_alloc();
    });
    return 0;
  });
  REQUIRE(!done);
  CHECK(done.error().code == ServiceCode::overloaded);
  CHECK(pool.run([](Worker&) -> Result<int> { return 7; }) == 7);
}

TEST_CASE("jobs with help, tables and others come and go together") {
  ComputePool pool(3, 64);
  std::vector<std::thread> clients;
  for (std::uint32_t client = 0; client < 6; ++client) {
    clients.emplace_back([&pool, seed = test_seed() + client] {
      std::mt19937 random(seed);
      for (int i = 0; i < 40; ++i) {
        const std::uint64_t steps = 1 + random() % 400;
        const auto job = [&](Worker&) -> Result<std::uint64_t> {
          ComputePool::Help help(pool);
          return sum_in_steps(help.team(), steps);
        };
        switch (random() % 3) {
          case 0:
            CHECK(pool.run(job) == sum_of(steps));
            break;
          case 1:
            CHECK(pool.run([](Worker&) -> Result<int> { return 7; }) == 7);
            break;
          default:
            CHECK(pool.run_each(1 + random() % 5,
                                [&](Worker&, std::size_t, const GiveWay& give_way) -> Result<void> {
                                  if (give_way()) return fail(ErrorCode::cancelled, "gives way");
                                  ComputePool::Help help(pool);
                                  CHECK(sum_in_steps(help.team(), steps) == sum_of(steps));
                                  return {};
                                },
                                {}));
        }
      }
    });
  }
  for (std::thread& client : clients) client.join();
  wait_until([&] { return pool.stats().running == 0; });
  CHECK(pool.stats().helping == 0);
  pool.drain();
}

TEST_CASE("a pool that drains waits for the job and for those that help it") {
  ComputePool pool(2, 4);
  std::atomic<bool> is_draining{false};
  std::thread long_one([&] {
    CHECK(pool.run([&](Worker&) -> Result<std::uint64_t> {
      ComputePool::Help help(pool);
      wait_until([&] { return is_draining.load(); });
      return sum_in_steps(help.team(), 5000);
    }) == sum_of(5000));
  });
  wait_until([&] { return pool.stats().helping == 1; });
  is_draining = true;
  pool.drain();
  long_one.join();
}
