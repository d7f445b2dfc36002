#include "server/base/turns.h"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

using namespace geodesic;
using namespace geodesic::server;
using namespace std::chrono_literals;

TEST_CASE("no more have their turn at once than may") {
  Turns turns(3, 1min, "too many");
  std::atomic<int> at_once{0};
  std::atomic<int> most{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 12; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) {
        const auto turn = turns.take(Caller());
        REQUIRE(turn);
        const int now = ++at_once;
        for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) continue;
        std::this_thread::yield();
        --at_once;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(most >= 1);
  CHECK(most <= 3);
}

TEST_CASE("who waits for a turn ends with the client, by the deadline, or after a while") {
  Turns turns(1, 20ms, "too many");
  auto held = turns.take(Caller());
  REQUIRE(held);
  const auto refused = turns.take(Caller());
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ServiceCode::overloaded);
  CHECK(refused.error().detail == "too many");
  CHECK(turns.take_now() == nullptr);

  std::atomic<int> asked{0};
  Caller patient([&] { return ++asked == 5; });
  patient.is_patient = true;
  const auto gone = turns.take(patient);
  REQUIRE_FALSE(gone);
  CHECK(gone.error().code == ErrorCode::cancelled);

  Caller late;
  late.is_patient = true;
  late.deadline = Caller::Clock::now() + 30ms;
  const auto over = turns.take(late);
  REQUIRE_FALSE(over);
  CHECK(over.error().code == ServiceCode::deadline);

  held->reset();
  CHECK(turns.take(Caller()));
  CHECK(turns.take_now() != nullptr);
}
