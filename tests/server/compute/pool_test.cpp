#include "server/compute/pool.h"

#include <doctest/doctest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "server/base/service_codes.h"
#include "tests/fixtures/wait_until.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace std::chrono_literals;
using geodesic::fixtures::wait_until;

namespace {

// Occupies slots until it is opened.
struct SlotGate {
  std::promise<void> promise;
  std::shared_future<void> opened = promise.get_future().share();
  void open() { promise.set_value(); }
  auto job() {
    return [this](Worker&) -> Result<int> {
      opened.wait();
      return 1;
    };
  }
};

}  // namespace

TEST_CASE("a job's result and error come back to the caller") {
  ComputePool pool(2, 4);
  CHECK(pool.slots() == 2);
  CHECK(pool.run([](Worker&) -> Result<std::string> { return std::string("done"); }) == "done");
  const auto failed =
      pool.run([](Worker&) -> Result<int> { return fail(ErrorCode::no_hit, "misses"); });
  REQUIRE_FALSE(failed);
  CHECK(failed.error().code == ErrorCode::no_hit);
  // Results that can only be moved, and none at all.
  const auto moved =
      pool.run([](Worker&) -> Result<std::unique_ptr<int>> { return std::make_unique<int>(7); });
  CHECK(**moved == 7);
  CHECK(pool.run([](Worker&) -> Result<void> { return {}; }));
  CHECK(ComputePool(0, 1).slots() >= 1);
}

TEST_CASE("what a job throws becomes an error without details") {
  ComputePool pool(1, 1);
  const auto thrown =
      pool.run([](Worker&) -> Result<int> { throw std::runtime_error("a secret"); });
  REQUIRE_FALSE(thrown);
  CHECK(thrown.error().code == ErrorCode::internal);
  CHECK(thrown.error().detail.find("secret") == std::string::npos);
  const auto number = pool.run([](Worker&) -> Result<int> { throw 42; });
  CHECK(number.error().code == ErrorCode::internal);
  const auto memory = pool.run([](Worker&) -> Result<int> { throw std::bad_alloc(); });
  CHECK(memory.error().code == ServiceCode::overloaded);
  CHECK(pool.run([](Worker&) -> Result<int> { return 1; }) == 1);
}

TEST_CASE("a full queue is refused at once") {
  SlotGate gate;
  ComputePool pool(1, 2);
  std::vector<std::future<Result<int>>> callers;
  for (int i = 0; i < 3; ++i) {  // one runs, two wait
    callers.push_back(std::async(std::launch::async, [&] { return pool.run(gate.job()); }));
  }
  wait_until([&] { return pool.stats().running == 1 && pool.stats().queued == 2; });
  const auto refused = pool.run(gate.job());
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ServiceCode::overloaded);
  CHECK(refused.error().limit == 2);
  gate.open();
  for (auto& caller : callers) CHECK(caller.get() == 1);
  CHECK(pool.stats().rejected == 1);
  CHECK(pool.stats().finished == 3);
  CHECK(pool.stats().running == 0);
}

TEST_CASE("a patient caller waits however full the queue is") {
  SlotGate gate;
  ComputePool pool(1, ComputePool::QueueLimits{1, 1, 1ms});
  std::vector<std::future<Result<int>>> callers;
  const auto call = [&](bool is_patient) {
    Caller caller;
    caller.client = "one and the same";
    caller.is_patient = is_patient;
    return std::async(std::launch::async, [&, caller] { return pool.run(gate.job(), caller); });
  };
  callers.push_back(call(true));
  wait_until([&] { return pool.stats().running == 1; });
  for (int i = 0; i < 3; ++i) callers.push_back(call(true));
  wait_until([&] { return pool.stats().queued == 3; });
  CHECK(call(false).get().error().code == ServiceCode::too_many_requests);
  gate.open();
  for (auto& caller : callers) CHECK(caller.get() == 1);
}

TEST_CASE("a job that can wait is not sent away for another's, and takes nobody's place") {
  SlotGate gate;
  ComputePool pool(1, 2);
  std::vector<std::future<Result<int>>> patient;
  const auto call = [&](const char* client, bool is_patient) {
    Caller caller;
    caller.client = client;
    caller.is_patient = is_patient;
    return std::async(std::launch::async, [&, caller] { return pool.run(gate.job(), caller); });
  };
  patient.push_back(call("greedy", true));
  wait_until([&] { return pool.stats().running == 1; });
  for (int i = 0; i < 4; ++i) patient.push_back(call("greedy", true));
  wait_until([&] { return pool.stats().queued == 4; });
  // The queue has two places, and none of them is taken.
  auto first = call("meek", false);
  wait_until([&] { return pool.stats().queued == 5; });
  auto second = call("greedy", false);
  wait_until([&] { return pool.stats().queued == 6; });
  // Full. Most of what waits is the greedy one's, but only one of these can go, and nobody
  // has more of such than the newcomer would have.
  CHECK(call("third", false).get().error().code == ServiceCode::overloaded);
  gate.open();
  for (auto& caller : patient) CHECK(caller.get() == 1);
  CHECK(first.get() == 1);
  CHECK(second.get() == 1);
  CHECK(pool.stats().rejected == 1);
}

TEST_CASE("what finishes a request goes before all that wait, and is not refused") {
  SlotGate gate;
  ComputePool pool(1, ComputePool::QueueLimits{1, 1, 10ms});
  auto running = std::async(std::launch::async, [&] { return pool.run(gate.job()); });
  wait_until([&] { return pool.stats().running == 1; });
  std::mutex mutex;
  std::string order;
  const auto note = [&](char name) {
    return [&, name](Worker&) -> Result<int> {
      const std::lock_guard lock(mutex);
      order += name;
      return 1;
    };
  };
  Caller waiting;
  waiting.client = "a";
  waiting.is_patient = true;
  auto first = std::async(std::launch::async, [&] { return pool.run(note('p'), waiting); });
  wait_until([&] { return pool.stats().queued == 1; });
  Caller own;
  own.client = "a";
  const Caller rest = own.finishing();
  auto second = std::async(std::launch::async, [&] { return pool.run(note('1'), rest); });
  wait_until([&] { return pool.stats().queued == 2; });
  auto third = std::async(std::launch::async, [&] { return pool.run(note('2'), rest); });
  wait_until([&] { return pool.stats().queued == 3; });
  std::this_thread::sleep_for(30ms);  // longer than others may wait
  gate.open();
  CHECK(second.get() == 1);
  CHECK(third.get() == 1);
  CHECK(first.get() == 1);
  CHECK(running.get() == 1);
  CHECK(order == "12p");
}

TEST_CASE("what finishes a request is taken back when its client is gone") {
  SlotGate gate;
  ComputePool pool(1, 0);
  auto running = std::async(std::launch::async, [&] { return pool.run(gate.job()); });
  wait_until([&] { return pool.stats().running == 1; });
  std::atomic<bool> gone{false};
  Caller caller([&] { return gone.load(); });
  auto rest = std::async(std::launch::async, [&] {
    return pool.run([](Worker&) -> Result<int> { return 1; }, caller.finishing());
  });
  wait_until([&] { return pool.stats().queued == 1; });
  gone = true;
  const auto answer = rest.get();
  REQUIRE_FALSE(answer);
  CHECK(answer.error().code == ErrorCode::cancelled);
  CHECK(pool.stats().queued == 0);
  gate.open();
  CHECK(running.get() == 1);
}

TEST_CASE("without a queue, a free slot is taken and a busy one refused") {
  SlotGate gate;
  ComputePool pool(1, 0);
  auto running = std::async(std::launch::async, [&] { return pool.run(gate.job()); });
  wait_until([&] { return pool.stats().running == 1; });
  CHECK(pool.run(gate.job()).error().code == ServiceCode::overloaded);
  gate.open();
  CHECK(running.get() == 1);
}

TEST_CASE("a caller whose client is gone takes its queued job back") {
  SlotGate gate;
  ComputePool pool(1, 4);
  auto running = std::async(std::launch::async, [&] { return pool.run(gate.job()); });
  wait_until([&] { return pool.stats().running == 1; });
  std::atomic<bool> ran{false};
  std::atomic<bool> gone{false};
  auto queued = std::async(std::launch::async, [&] {
    return pool.run(
        [&](Worker&) -> Result<int> {
          ran = true;
          return 2;
        },
        [&] { return gone.load(); });
  });
  wait_until([&] { return pool.stats().queued == 1; });
  CHECK(queued.wait_for(150ms) == std::future_status::timeout);  // it waits while the client does
  gone = true;
  REQUIRE(queued.wait_for(2s) == std::future_status::ready);
  CHECK(queued.get().error().code == ErrorCode::cancelled);
  CHECK(pool.stats().queued == 0);
  CHECK(pool.stats().given_up == 1);
  gate.open();
  CHECK(running.get() == 1);
  CHECK_FALSE(ran);
}

TEST_CASE("a running job is waited for even if the client is gone") {
  SlotGate gate;
  ComputePool pool(1, 4);
  auto running =
      std::async(std::launch::async, [&] { return pool.run(gate.job(), [] { return true; }); });
  CHECK(running.wait_for(200ms) == std::future_status::timeout);
  gate.open();
  CHECK(running.get() == 1);
}

TEST_CASE("no two jobs at once share a slot") {
  ComputePool pool(4, 64);
  std::vector<std::atomic<int>> in_slot(4);
  std::atomic<int> wrong{0};
  std::vector<std::future<int>> callers;
  for (int c = 0; c < 16; ++c) {
    callers.push_back(std::async(std::launch::async, [&] {
      int done = 0;
      for (int i = 0; i < 100; ++i) {
        const auto ran = pool.run([&](Worker& worker) -> Result<int> {
          if (worker.slot >= 4 || ++in_slot[worker.slot] != 1) ++wrong;
          std::this_thread::yield();
          --in_slot[worker.slot];
          return 1;
        });
        done += ran.value_or(0);
      }
      return done;
    }));
  }
  for (auto& caller : callers) CHECK(caller.get() == 100);
  CHECK(wrong == 0);
  CHECK(pool.stats().finished == 1600);
}

TEST_CASE("draining finishes what is queued and refuses what comes") {
  SlotGate gate;
  ComputePool pool(1, 4);
  std::vector<std::future<Result<int>>> callers;
  for (int i = 0; i < 3; ++i) {
    callers.push_back(std::async(std::launch::async, [&] { return pool.run(gate.job()); }));
  }
  wait_until([&] { return pool.stats().running == 1 && pool.stats().queued == 2; });
  auto drained = std::async(std::launch::async, [&] { pool.drain(); });
  wait_until([&] {
    const auto tried = pool.run([](Worker&) -> Result<int> { return 1; }, [] { return true; });
    return !tried && tried.error().code == ServiceCode::draining;
  });
  CHECK(drained.wait_for(50ms) == std::future_status::timeout);
  gate.open();
  drained.get();
  for (auto& caller : callers) CHECK(caller.get() == 1);
  pool.drain();
}

TEST_CASE("a greedy client's jobs make room for others, who get their turns") {
  SlotGate gate;
  ComputePool pool(1, 4);
  const auto of = [](std::string client) {
    Caller caller;
    caller.client = std::move(client);
    return caller;
  };
  auto running = std::async(std::launch::async, [&] { return pool.run(gate.job(), of("x")); });
  wait_until([&] { return pool.stats().running == 1; });

  std::mutex mutex;
  std::vector<std::string> order;
  const auto start = [&](const std::string& client) {
    auto job = std::async(std::launch::async, [&, client] {
      return pool.run(
          [&, client](Worker&) -> Result<int> {
            const std::lock_guard lock(mutex);
            order.push_back(client);
            return 1;
          },
          of(client));
    });
    return job;
  };
  std::vector<std::future<Result<int>>> greedy;
  for (std::uint64_t i = 0; i < 4; ++i) {
    greedy.push_back(start("greedy"));
    wait_until([&] { return pool.stats().queued == i + 1; });
  }
  // Alone, it has no share to exceed: the server is full.
  CHECK(start("greedy").get().error().code == ServiceCode::overloaded);
  // The newest of its jobs is sent away for another's.
  auto meek = start("meek");
  CHECK(greedy[3].get().error().code == ServiceCode::too_many_requests);
  // Now it is not alone any more, and most of the queue is its own.
  wait_until([&] { return pool.stats().clients == 2; });
  CHECK(start("greedy").get().error().code == ServiceCode::too_many_requests);
  CHECK(pool.stats().rejected == 3);
  gate.open();
  CHECK(meek.get() == 1);
  for (int i = 0; i < 3; ++i) CHECK(greedy[static_cast<std::size_t>(i)].get() == 1);
  CHECK(order == std::vector<std::string>{"greedy", "meek", "greedy", "greedy"});
  CHECK(running.get() == 1);
}

TEST_CASE("one client's jobs have a bound of their own") {
  SlotGate gate;
  ComputePool pool(1, ComputePool::QueueLimits{10, 1, 0ms});
  Caller caller;
  caller.client = "a";
  auto running = std::async(std::launch::async, [&] { return pool.run(gate.job(), caller); });
  wait_until([&] { return pool.stats().running == 1; });
  auto queued = std::async(std::launch::async, [&] { return pool.run(gate.job(), caller); });
  wait_until([&] { return pool.stats().queued == 1; });
  const auto refused = pool.run(gate.job(), caller);
  CHECK(refused.error().code == ServiceCode::too_many_requests);
  CHECK(refused.error().limit == 1);
  gate.open();
  CHECK(running.get() == 1);
  CHECK(queued.get() == 1);
}

TEST_CASE("a queued job whose deadline passes ends with deadline, and never runs") {
  SlotGate gate;
  ComputePool pool(1, 4);
  auto running = std::async(std::launch::async, [&] { return pool.run(gate.job()); });
  wait_until([&] { return pool.stats().running == 1; });
  std::atomic<bool> ran{false};
  Caller caller;
  caller.deadline = Caller::Clock::now() + 50ms;
  const auto job = [&](Worker&) -> Result<int> {
    ran = true;
    return 2;
  };
  CHECK(pool.run(job, caller).error().code == ServiceCode::deadline);
  CHECK(pool.run(job, caller).error().code == ServiceCode::deadline);  // over before it queues
  CHECK(pool.stats().queued == 0);
  gate.open();
  CHECK(running.get() == 1);
  CHECK_FALSE(ran);
}

TEST_CASE("a running job that stops for its deadline ends with deadline") {
  ComputePool pool(1, 4);
  Caller caller;
  caller.deadline = Caller::Clock::now() + 20ms;
  const auto stopped = pool.run(
      [&](Worker&) -> Result<int> {
        wait_until([&] { return caller(); });  // as a computation polls its Cancel
        return fail(ErrorCode::cancelled, "cancelled");
      },
      caller);
  CHECK(stopped.error().code == ServiceCode::deadline);
}

TEST_CASE("a job that does not stop is counted and named, and its slot comes back") {
  std::ostringstream log;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
  for (const bool by_deadline : {true, false}) {
    SlotGate gate;
    ComputePool pool(1, 4);
    std::atomic<bool> is_gone{false};
    Caller caller([&] { return is_gone.load(); });
    caller.asked = std::make_shared<const Caller::Asked>(
        Caller::Asked{by_deadline ? "request-7" : "request-8", "GET", "/v1/meshes/a/path?to=v:9"});
    std::future<Result<int>> stuck;
    bool has_begun = false;
    // On a machine that stands still, the deadline may pass before the job begins.
    for (auto time = 20ms; !has_begun; time *= 2) {
      if (by_deadline) caller.deadline = Caller::Clock::now() + time;
      stuck = std::async(std::launch::async, [&] { return pool.run(gate.job(), caller); });
      wait_until([&] {
        has_begun = pool.stats().running == 1;
        return has_begun || stuck.wait_for(0s) == std::future_status::ready;
      });
      if (!has_begun) CHECK(stuck.get().error().code == ServiceCode::deadline);
    }
    const auto begin = by_deadline ? *caller.deadline : Caller::Clock::now();
    is_gone = !by_deadline;
    wait_until([&] { return pool.stats().unanswering == 1; });
    CHECK(Caller::Clock::now() - begin >= 1s);
    CHECK(pool.stats().unanswered == 1);
    gate.open();
    CHECK(stuck.get() == 1);
    CHECK(pool.stats().unanswering == 0);
    CHECK(pool.stats().unanswered == 1);
    CHECK(pool.run([](Worker&) -> Result<int> { return 2; }) == 2);
  }
  spdlog::set_default_logger(before);
  const std::string named = "request-7 GET /v1/meshes/a/path?to=v:9 still computes ";
  const std::size_t at = log.str().find(named);
  REQUIRE(at != std::string::npos);
  CHECK(std::stod(log.str().substr(at + named.size())) >= 1);  // seconds after its deadline
  CHECK(log.str().find("request-8 GET /v1/meshes/a/path?to=v:9 has ended") != std::string::npos);
}

TEST_CASE("a job that stops in time is not counted as one that does not") {
  // Where the machine stood still for so long, it did not stop in time.
  for (bool was_in_time = false; !was_in_time;) {
    ComputePool pool(1, 4);
    Caller caller;
    caller.deadline = Caller::Clock::now() + 20ms;
    const auto stopped = pool.run(
        [&](Worker&) -> Result<int> {
          std::this_thread::sleep_for(200ms);
          return fail(ErrorCode::cancelled, "cancelled");
        },
        caller);
    CHECK(stopped.error().code == ServiceCode::deadline);
    const std::uint64_t unanswered = pool.stats().unanswered;
    was_in_time = Caller::Clock::now() < *caller.deadline + 1s;
    if (was_in_time) CHECK(unanswered == 0);
  }
}

TEST_CASE("a wait has a bound, and a deadline that cannot be met is refused at once") {
  SlotGate gate;
  ComputePool pool(1, ComputePool::QueueLimits{100, 0, 100ms});
  // What jobs took lately.
  for (int i = 0; i < 4; ++i) {
    CHECK(pool.run([](Worker&) -> Result<int> {
      std::this_thread::sleep_for(400ms);
      return 1;
    }) == 1);
  }
  auto running = std::async(std::launch::async, [&] { return pool.run(gate.job()); });
  wait_until([&] { return pool.stats().running == 1; });
  // There is no line yet, so the estimate does not count; but the bound does.
  auto waits = std::async(std::launch::async, [&] { return pool.run(gate.job()); });
  const auto late = waits.get();
  CHECK(late.error().code == ServiceCode::overloaded);
  CHECK(pool.stats().rejected == 1);
  gate.open();
  CHECK(running.get() == 1);

  SlotGate second;
  ComputePool unbounded(1, 100);
  CHECK(unbounded.run([](Worker&) -> Result<int> {
    std::this_thread::sleep_for(400ms);
    return 1;
  }) == 1);
  auto holds = std::async(std::launch::async, [&] { return unbounded.run(second.job()); });
  wait_until([&] { return unbounded.stats().running == 1; });
  std::vector<std::future<Result<int>>> line;
  for (std::uint64_t i = 0; i < 20; ++i) {
    line.push_back(std::async(std::launch::async, [&] { return unbounded.run(second.job()); }));
    wait_until([&] { return unbounded.stats().queued == i + 1; });
  }
  Caller hurried;
  hurried.deadline = Caller::Clock::now() + 100ms;  // twenty jobs of some 25 ms are ahead
  CHECK(unbounded.run(second.job(), hurried).error().code == ServiceCode::overloaded);
  second.open();
  CHECK(holds.get() == 1);
  for (auto& job : line) CHECK(job.get() == 1);
}
