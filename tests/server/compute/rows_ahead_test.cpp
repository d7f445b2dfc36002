// Rows in their order, while others are computed.
#include "server/compute/rows_ahead.h"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <new>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "server/base/service_codes.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/wait_until.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace std::chrono_literals;
using geodesic::fixtures::test_seed;
using geodesic::fixtures::wait_until;

namespace {

std::unique_ptr<RowsAhead> begun(ComputePool& pool, std::size_t count, std::size_t block,
                                 RowsAhead::Compute compute, Caller caller = {}) {
  auto rows = RowsAhead::begin(pool, count, block, std::move(compute), std::move(caller));
  REQUIRE(rows);
  return std::move(*rows);
}

Result<std::string> name_of_row(Worker&, std::size_t row, const GiveWay&, const Caller&) {
  return std::to_string(row);
}

}  // namespace

TEST_CASE("rows come once each and in their order, whatever the slots and the blocks") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 30; ++round) {
    const std::size_t slots = 1 + random() % 4;
    const std::size_t count = 1 + random() % 60;
    const std::size_t block = 1 + random() % 12;
    const bool is_slow = random() % 2 == 0;
    CAPTURE(slots);
    CAPTURE(count);
    CAPTURE(block);
    ComputePool pool(slots, 4);
    const auto rows =
        begun(pool, count, block,
              [&](Worker&, std::size_t row, const GiveWay&, const Caller&) -> Result<std::string> {
                if (is_slow && row % 5 == 0) std::this_thread::sleep_for(1ms);
                return std::to_string(row);
              });
    for (std::size_t i = 0; i < count; ++i) {
      const auto row = rows->next();
      REQUIRE(row);
      REQUIRE(*row);
      CHECK(**row == std::to_string(i));
    }
    for (int i = 0; i < 2; ++i) {
      const auto end = rows->next();
      REQUIRE(end);
      CHECK_FALSE(*end);
    }
    wait_until([&] { return pool.stats().finished == count; });
  }
}

TEST_CASE("no more than two blocks are ahead of whoever takes them") {
  ComputePool pool(2, 4);
  std::atomic<std::size_t> done{0};
  const auto rows =
      begun(pool, 100, 5,
            [&](Worker& worker, std::size_t row, const GiveWay& give_way, const Caller& caller) {
              ++done;
              return name_of_row(worker, row, give_way, caller);
            });
  for (std::size_t taken = 0; taken < 100; ++taken) {
    const auto row = rows->next();
    REQUIRE(row);
    CHECK(done <= taken + 1 + 2 * 5);
  }
  CHECK(done == 100);
}

TEST_CASE("rows before one that fails are handed out") {
  ComputePool pool(3, 4);
  const auto rows =
      begun(pool, 40, 7,
            [](Worker&, std::size_t row, const GiveWay&, const Caller&) -> Result<std::string> {
              if (row == 17) return fail(ErrorCode::too_large, "this one", "row");
              if (row < 17) std::this_thread::sleep_for(1ms);
              return std::to_string(row);
            });
  std::size_t got = 0;
  while (true) {
    const auto row = rows->next();
    if (!row) {
      CHECK(row.error().code == ErrorCode::too_large);
      break;
    }
    REQUIRE(*row);
    CHECK(**row == std::to_string(got++));
  }
  CHECK(got >= 14);  // the blocks before its own
  CHECK(got <= 17);
  CHECK_FALSE(rows->next());  // and ever after
}

TEST_CASE("a row that throws is an error, and no more") {
  ComputePool pool(1, 4);
  const auto rows = begun(
      pool, 3, 2, [](Worker&, std::size_t, const GiveWay&, const Caller&) -> Result<std::string> {
        throw std::bad_alloc();
      });
  const auto row = rows->next();
  REQUIRE_FALSE(row);
  CHECK(row.error().code == ServiceCode::overloaded);
  CHECK(pool.run([](Worker&) { return Result<int>(7); }));
}

TEST_CASE("whoever does not want them any more ends what is computed") {
  ComputePool pool(2, 4);
  std::atomic<bool> is_begun{false};
  {
    const auto rows = begun(
        pool, 10, 4,
        [&](Worker&, std::size_t, const GiveWay&, const Caller& caller) -> Result<std::string> {
          is_begun = true;
          while (!caller()) std::this_thread::sleep_for(1ms);
          return fail(ErrorCode::cancelled, "nobody wants it");
        });
    wait_until([&] { return is_begun.load(); });
  }
  wait_until([&] { return pool.stats().running == 0; });
}

TEST_CASE("a caller that leaves, or is late, ends the rows") {
  ComputePool pool(1, 4);
  const auto wait = [](Worker&, std::size_t row, const GiveWay&,
                       const Caller& caller) -> Result<std::string> {
    while (row > 0 && !caller()) std::this_thread::sleep_for(1ms);
    if (row > 0) return fail(ErrorCode::cancelled, "nobody wants it");
    return std::string("first");
  };
  std::atomic<bool> is_gone{false};
  const auto rows = begun(pool, 5, 2, wait, Caller([&] { return is_gone.load(); }));
  REQUIRE(rows->next());
  is_gone = true;
  CHECK(rows->next().error().code == ErrorCode::cancelled);
  Caller late;
  late.deadline = Caller::Clock::now() + 200ms;
  const auto others = begun(pool, 5, 2, wait, late);
  const auto first = others->next();
  if (first) CHECK(others->next().error().code == ServiceCode::deadline);
}

TEST_CASE("rows that have begun are not sent away for a full queue") {
  // No place in the queue but for who may wait.
  ComputePool pool(1, 0);
  constexpr int kRows = 60;  // no more than two blocks are there before they are taken
  std::atomic<bool> is_held{true};
  std::atomic<bool> is_running{false};
  const auto rows = begun(pool, kRows, 3, name_of_row);
  for (int i = 0; i < 3; ++i) REQUIRE(rows->next());
  std::future<Result<int>> other = std::async(std::launch::async, [&] {
    while (true) {
      auto ran = pool.run([&](Worker&) -> Result<int> {
        is_running = true;
        wait_until([&] { return !is_held; });
        return 1;
      });
      if (ran) return ran;
      std::this_thread::sleep_for(1ms);
    }
  });
  wait_until([&] { return is_running.load(); });
  auto rest = std::async(std::launch::async, [&] {
    // The next block waits for its turn, behind who has the slot.
    wait_until([&] { return pool.stats().queued == 1; });
    is_held = false;
  });
  for (int i = 3; i < kRows; ++i) {
    const auto row = rows->next();
    REQUIRE(row);
    CHECK(**row == std::to_string(i));
  }
  CHECK(other.get());
}

TEST_CASE("the rows' progress is that of the caller") {
  ComputePool pool(2, 4);
  std::mutex mutex;
  double most = 0;
  Caller caller;
  caller.progress = [&](double done) {
    const std::lock_guard lock(mutex);
    CHECK(done >= 0);
    CHECK(done <= 1);
    most = std::max(most, done);
  };
  auto rows = begun(pool, 20, 6, name_of_row, caller);
  for (int i = 0; i < 10; ++i) REQUIRE(rows->next());
  {
    // A row may be taken before it is told that it is done: two are in the making, so 8 of 20 are
    // told, summed up with rounding.
    const std::lock_guard lock(mutex);
    CHECK(most > 0.39);
  }
  while (true) {
    const auto row = rows->next();
    REQUIRE(row);
    if (!*row) break;
  }
  rows.reset();  // and so is the last one: its slot has ended
  CHECK(most == doctest::Approx(1));
}
