// Jobs that have no room beside others wait for it without holding anything, and get it.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include "server/base/service_codes.h"
#include "server/compute/pool.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/compute/taken_memory.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using namespace std::chrono_literals;
using geodesic::fixtures::is_soon;
using geodesic::fixtures::wait_until;

namespace {

// Holds memory in a slot until it is told to leave.
class Holder {
 public:
  Holder(ComputePool& pool, std::uint64_t bytes)
      : done_(std::async(std::launch::async, [this, &pool, bytes] {
          return pool.run([&](Worker&) -> Result<int> {
            const Taken memory(bytes);
            held_.set_value();
            leave_.get_future().wait();
            return 1;
          });
        })) {
    held_.get_future().wait();
  }
  ~Holder() { leave(); }
  void leave() {
    if (!done_.valid()) return;
    leave_.set_value();
    CHECK(done_.get() == 1);
  }

 private:
  std::promise<void> held_;
  std::promise<void> leave_;
  std::future<Result<int>> done_;
};

}  // namespace

TEST_CASE("a job without room leaves its slot, and runs again when there is room") {
  ComputePool pool(2, 8);
  pool.set_memory_limits({80 * kMiB, 100 * kMiB});
  Holder holder(pool, 60 * kMiB);
  std::atomic<int> begun = 0;
  auto large = std::async(std::launch::async, [&] {
    return pool.run_with_room([&](Worker& worker) -> Result<std::size_t> {
      ++begun;
      return query_taking(50 * kMiB)(worker);
    });
  });
  wait_until([&] { return pool.memory().crowded_out == 1; });
  // Its slot is another's meanwhile.
  for (int i = 0; i < 5; ++i) CHECK(pool.run_with_room(query_taking(30 * kMiB)) == 30 * kMiB);
  CHECK(large.wait_for(0s) == std::future_status::timeout);
  holder.leave();
  CHECK(large.get() == 50 * kMiB);
  CHECK(begun >= 2);
  CHECK(pool.memory().bytes == 0);
}

TEST_CASE("a job without room goes on once it has some, though others run on") {
  ComputePool pool(3, 8);
  pool.set_memory_limits({80 * kMiB, 100 * kMiB});
  Holder large(pool, 60 * kMiB);
  Holder small(pool, 10 * kMiB);
  auto waiting =
      std::async(std::launch::async, [&] { return pool.run_with_room(query_taking(50 * kMiB)); });
  wait_until([&] { return pool.memory().crowded_out == 1; });
  large.leave();
  CHECK(waiting.wait_for(60s) == std::future_status::ready);
  CHECK(pool.stats().running == 1);  // the small one
  small.leave();
  CHECK(waiting.get() == 50 * kMiB);
}

TEST_CASE("who waits for room goes when nobody wants it any more, or it takes too long") {
  ComputePool pool(2, {8, 0, 300ms});
  pool.set_memory_limits({80 * kMiB, 100 * kMiB});
  Holder holder(pool, 60 * kMiB);
  const auto late = pool.run_with_room(query_taking(50 * kMiB));
  REQUIRE_FALSE(late);
  CHECK(late.error().code == ServiceCode::overloaded);
  CHECK(late.error().limit == 100 * kMiB);
  Caller hurried;
  hurried.deadline = Caller::Clock::now() + 100ms;
  CHECK(pool.run_with_room(query_taking(50 * kMiB), hurried).error().code == ServiceCode::deadline);
  Caller leaving;
  const auto gone_at = Caller::Clock::now() + 100ms;
  leaving.gone = [&] { return Caller::Clock::now() >= gone_at; };
  CHECK(pool.run_with_room(query_taking(50 * kMiB), leaving).error().code == ErrorCode::cancelled);
  // What is too much for one alone does not wait.
  const auto refused = pool.run_with_room(query_taking(90 * kMiB));
  CHECK(refused.error().code == ServiceCode::too_much_memory);
  CHECK(pool.stats().running == 1);
}

TEST_CASE("what idle slots keep makes room for a job that alone could have it") {
  constexpr std::size_t kSlots = 4;
  ComputePool pool(kSlots, 16);
  pool.set_memory_limits({90 * kMiB, 100 * kMiB});
  std::array<std::unique_ptr<Taken>, kSlots> kept;
  pool.observe_want_of_room([&](Worker& worker) { kept[worker.slot].reset(); });
  // Each slot keeps 10 MiB: all of them are busy at once.
  std::atomic<std::size_t> running = 0;
  std::vector<std::future<Result<int>>> keeping;
  for (std::size_t i = 0; i < kSlots; ++i) {
    keeping.push_back(std::async(std::launch::async, [&] {
      return pool.run([&](Worker& worker) -> Result<int> {
        kept[worker.slot] = std::make_unique<Taken>(10 * kMiB);
        ++running;
        while (running < kSlots) std::this_thread::yield();
        worker.memory->keep(worker.memory->held());
        return 1;
      });
    }));
  }
  for (auto& job : keeping) CHECK(job.get() == 1);
  CHECK(pool.memory().bytes >= 40 * kMiB);
  CHECK(pool.run_with_room(query_taking(85 * kMiB)) == 85 * kMiB);
  CHECK(pool.memory().bytes <= 12 * kMiB);  // what one that never was idle may keep
  pool.observe_want_of_room({});
}

TEST_CASE("parts that have no room beside each other are done with fewer slots") {
  ComputePool pool(4, 8);
  pool.set_memory_limits({80 * kMiB, 100 * kMiB});
  std::array<std::atomic<int>, 12> done{};
  const auto part = [&](Worker& worker, std::size_t i, const GiveWay&) -> Result<void> {
    worker.memory->limit_to_query();
    const Taken memory(40 * kMiB);
    // Kept until a part has met it and found no room, however late its thread starts.
    CHECK(is_soon([&] { return pool.memory().crowded_out > 0; }));
    ++done[i];
    return {};
  };
  CHECK(pool.run_each(done.size(), part, {}));
  for (const auto& times : done) CHECK(times == 1);
  CHECK(pool.memory().crowded_out > 0);
  CHECK(pool.memory().bytes == 0);
}

// No deadlock, and no starvation: jobs that each fit alone all come to their end, however many
// there are and whatever they take.
TEST_CASE("any jobs that fit alone are all answered") {
  std::mt19937 random(fixtures::test_seed());
  ComputePool pool(4, 64);
  pool.set_memory_limits({90 * kMiB, 100 * kMiB});
  std::vector<std::future<Result<std::size_t>>> jobs;
  for (int i = 0; i < 40; ++i) {
    const std::uint64_t bytes = (1 + random() % 60) * kMiB;
    jobs.push_back(std::async(std::launch::async, [&pool, bytes] {
      // Which of them are crowded out again, and how often, is a matter of luck.
      for (;;) {
        auto taken = pool.run_with_room([bytes](Worker& worker) -> Result<std::size_t> {
          worker.memory->limit_to_query();
          const Taken half(bytes / 2);
          std::this_thread::sleep_for(2ms);
          const Taken rest(bytes - bytes / 2);
          std::this_thread::sleep_for(2ms);
          return bytes;
        });
        if (taken || taken.error().code != ServiceCode::overloaded) return taken;
      }
    }));
  }
  for (auto& job : jobs) CHECK(job.get());
  CHECK(pool.memory().bytes == 0);
}
