// Computations of many parts: by as many slots as nobody else wants.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <numeric>
#include <thread>
#include <vector>

#include "server/base/service_codes.h"
#include "server/compute/pool.h"
#include "tests/fixtures/wait_until.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace std::chrono_literals;
using geodesic::fixtures::wait_until;

TEST_CASE("every part is done once, whatever the number of slots") {
  for (const std::size_t slots : {1, 2, 4}) {
    CAPTURE(slots);
    ComputePool pool(slots, 4);
    std::vector<int> done(500, 0);  // each written by one thread, read when all have ended
    std::vector<std::atomic<int>> on_slot(slots);
    const auto all = pool.run_each(
        done.size(),
        [&](Worker& worker, std::size_t i, const GiveWay&) -> Result<void> {
          CHECK(on_slot[worker.slot].fetch_add(1) == 0);  // nobody shares its scratch memory
          ++done[i];
          on_slot[worker.slot].fetch_sub(1);
          return {};
        },
        {});
    REQUIRE(all);
    CHECK(std::all_of(done.begin(), done.end(), [](int times) { return times == 1; }));
    CHECK(pool.stats().finished == done.size());
    CHECK(pool.stats().running == 0);
    CHECK(pool.stats().helping == 0);
  }
}

TEST_CASE("no parts need no slot") {
  ComputePool pool(1, 0);
  const auto never = [](Worker&, std::size_t, const GiveWay&) -> Result<void> {
    return fail(ErrorCode::internal, "there is none");
  };
  CHECK(pool.run_each(0, never, {}));
}

TEST_CASE("free slots help") {
  ComputePool pool(3, 4);
  std::atomic<int> together{0};
  // None ends before all three have begun.
  const auto all = pool.run_each(3,
                                 [&](Worker&, std::size_t, const GiveWay&) -> Result<void> {
                                   together.fetch_add(1);
                                   wait_until([&] { return together == 3; });
                                   return {};
                                 },
                                 {});
  CHECK(all);
}

TEST_CASE("a slot that helps gives way to whoever waits, and its part is done later") {
  ComputePool pool(2, 4);
  std::atomic<bool> is_answered{false};
  std::atomic<int> begun{0};
  std::atomic<int> given_up{0};
  std::vector<int> done(2, 0);
  auto table = std::async(std::launch::async, [&] {
    return pool.run_each(done.size(),
                         [&](Worker&, std::size_t i, const GiveWay& give_way) -> Result<void> {
                           begun.fetch_add(1);
                           // Both would run until the other's job is done.
                           while (!is_answered) {
                             if (give_way()) {
                               given_up.fetch_add(1);
                               return fail(ErrorCode::cancelled, "later");
                             }
                             std::this_thread::sleep_for(1ms);
                           }
                           ++done[i];
                           return {};
                         },
                         {});
  });
  wait_until([&] { return begun == 2; });
  CHECK(pool.stats().running == 2);
  CHECK(pool.stats().helping == 1);
  const auto answer = pool.run([&](Worker&) -> Result<int> {
    is_answered = true;
    return 7;
  });
  CHECK(answer == 7);
  CHECK(table.get());
  CHECK(given_up == 1);
  CHECK(done == std::vector<int>{1, 1});
}

TEST_CASE("a job waits for one part at most, and is not refused for helping slots") {
  ComputePool pool(2, 0);  // nothing may wait
  std::atomic<std::size_t> parts{0};
  std::atomic<std::size_t> parts_when_answered{0};
  std::atomic<bool> is_over{false};
  auto table = std::async(std::launch::async, [&] {
    return pool.run_each(100,
                         [&](Worker&, std::size_t, const GiveWay& give_way) -> Result<void> {
                           for (int i = 0; i < 10; ++i) {
                             if (give_way()) return fail(ErrorCode::cancelled, "later");
                             std::this_thread::sleep_for(1ms);
                           }
                           parts.fetch_add(1);
                           return {};
                         },
                         {});
  });
  wait_until([&] { return pool.stats().running == 2; });
  for (int i = 0; i < 20; ++i) {
    const std::size_t before = parts;
    const auto answer = pool.run([&](Worker&) -> Result<int> { return 1; });
    REQUIRE(answer);
    CHECK(parts - before <= 8);
  }
  CHECK(table.get());
  CHECK(parts == 100);
}

TEST_CASE("what has begun and gave way is not refused for the queue's length") {
  ComputePool pool(1, 0);  // nobody may wait who is not patient
  std::atomic<int> parts{0};
  std::atomic<bool> is_over{false};
  auto table = std::async(std::launch::async, [&] {
    auto done = pool.run_each(3,
                              [&](Worker&, std::size_t, const GiveWay&) -> Result<void> {
                                parts.fetch_add(1);
                                wait_until([&] { return pool.stats().queued == 1; });
                                return {};
                              },
                              {});
    is_over = true;
    return done;
  });
  wait_until([&] { return parts == 1; });
  Caller patient;
  patient.is_patient = true;
  std::vector<std::future<Result<int>>> others;
  for (int i = 0; i < 3; ++i) {
    others.push_back(std::async(std::launch::async, [&] {
      return pool.run(
          [&](Worker&) -> Result<int> {
            // Until the rest of the table waits, or is refused.
            wait_until([&] { return pool.stats().queued > 0 || is_over; });
            return 7;
          },
          patient);
    }));
    wait_until([&] { return parts == i + 2 || is_over; });
  }
  for (auto& other : others) CHECK(other.get() == 7);
  CHECK(table.get());
}

TEST_CASE("two computations of many parts share the slots") {
  ComputePool pool(1, 4);
  std::atomic<int> turns{0};
  std::atomic<int> last_of_first{0};
  std::atomic<int> first_of_second{1000};
  const auto ask = [&](bool is_second) {
    return std::async(std::launch::async, [&, is_second] {
      Caller caller;
      caller.client = is_second ? "second" : "first";
      return pool.run_each(
          50,
          [&, is_second](Worker&, std::size_t, const GiveWay&) -> Result<void> {
            std::this_thread::sleep_for(1ms);
            const int turn = ++turns;
            if (is_second) {
              first_of_second = std::min(first_of_second.load(), turn);
            } else {
              last_of_first = turn;
            }
            return {};
          },
          caller);
    });
  };
  auto first = ask(false);
  wait_until([&] { return turns > 0; });
  auto second = ask(true);
  CHECK(first.get());
  CHECK(second.get());
  CHECK(turns == 100);
  CHECK(first_of_second < last_of_first);
}

TEST_CASE("the first part that fails ends the rest") {
  ComputePool pool(2, 4);
  std::atomic<std::size_t> begun{0};
  const auto failed = pool.run_each(1000,
                                    [&](Worker&, std::size_t i, const GiveWay&) -> Result<void> {
                                      begun.fetch_add(1);
                                      if (i == 3) return fail(ErrorCode::no_hit, "misses");
                                      std::this_thread::sleep_for(1ms);
                                      return {};
                                    },
                                    {});
  REQUIRE_FALSE(failed);
  CHECK(failed.error().code == ErrorCode::no_hit);
  CHECK(begun < 1000);
  const auto thrown =
      pool.run_each(5, [](Worker&, std::size_t, const GiveWay&) -> Result<void> { throw 42; }, {});
  CHECK(thrown.error().code == ErrorCode::internal);
  CHECK(pool.run([](Worker&) -> Result<int> { return 1; }) == 1);
}

TEST_CASE("a caller that is gone stops all slots, and a deadline says so") {
  ComputePool pool(2, 4);
  std::atomic<bool> is_gone{false};
  std::atomic<int> begun{0};
  Caller caller([&] { return is_gone.load(); });
  const auto polls = [&](Worker&, std::size_t, const GiveWay&) -> Result<void> {
    begun.fetch_add(1);
    wait_until([&] { return caller(); });
    return fail(ErrorCode::cancelled, "the computation was cancelled");
  };
  auto table = std::async(std::launch::async, [&] { return pool.run_each(50, polls, caller); });
  wait_until([&] { return begun == 2; });
  is_gone = true;
  CHECK(table.get().error().code == ErrorCode::cancelled);
  CHECK(begun == 2);

  is_gone = false;
  caller.deadline = Caller::Clock::now() + 20ms;
  CHECK(pool.run_each(50, polls, caller).error().code == ServiceCode::deadline);
  CHECK(pool.stats().running == 0);
}
