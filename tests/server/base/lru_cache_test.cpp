#include "server/base/lru_cache.h"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <latch>
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

// Values weigh what their text says, in bytes.
using Cache = LruCache<std::string>;

std::size_t length(const std::string& text) { return text.size(); }

auto making(std::string text) {
  return [text]() -> Result<Cache::Pointer> { return std::make_shared<const std::string>(text); };
}

void put(Cache& cache, const std::string& key, std::size_t bytes) {
  REQUIRE(cache.get_or_create(key, making(std::string(bytes, 'x'))));
}

}  // namespace

TEST_CASE("a value is made once and then hit") {
  Cache cache(100, length);
  CHECK(cache.find("a") == nullptr);
  const auto first = cache.get_or_create("a", making("hello"));
  REQUIRE(first);
  CHECK_FALSE(first->hit);
  const auto second = cache.get_or_create("a", making("other"));
  REQUIRE(second);
  CHECK(second->hit);
  CHECK(second->value == first->value);
  CHECK(cache.find("a") == first->value);
  const CacheStats stats = cache.stats();
  CHECK(stats.makes == 1);
  CHECK(stats.hits == 2);
  CHECK(stats.misses == 2);
  CHECK(stats.entries == 1);
  CHECK(stats.bytes == 5);
  CHECK(stats.budget == 100);
}

TEST_CASE("what was used least recently goes first, and holders keep it") {
  Cache cache(100, length);
  put(cache, "a", 40);
  put(cache, "b", 40);
  const Cache::Pointer a = cache.find("a");
  put(cache, "c", 40);  // b goes: a was used after it
  CHECK(cache.find("b") == nullptr);
  CHECK(cache.find("a") == a);
  CHECK(cache.stats().evictions == 1);
  cache.set_budget(0);
  CHECK(cache.stats().bytes == 0);
  CHECK(cache.stats().entries == 0);
  CHECK(a->size() == 40);
}

TEST_CASE("an entry over the budget is handed out, not kept, and evicts nothing") {
  Cache cache(100, length);
  put(cache, "small", 10);
  const auto large = cache.get_or_create("large", making(std::string(101, 'x')));
  REQUIRE(large);
  CHECK(large->value->size() == 101);
  CHECK(cache.find("large") == nullptr);
  CHECK(cache.find("small") != nullptr);
  put(cache, "exact", 100);
  CHECK(cache.find("exact") != nullptr);
  CHECK(cache.find("small") == nullptr);
}

TEST_CASE("a failure is not cached") {
  Cache cache(100, length);
  const auto failed = cache.get_or_create(
      "a", []() -> Result<Cache::Pointer> { return fail(ErrorCode::mesh_invalid, "broken"); });
  REQUIRE_FALSE(failed);
  CHECK(failed.error().code == ErrorCode::mesh_invalid);
  CHECK(cache.get_or_create("a", making("x")));
}

TEST_CASE("erasing forgets a key or all keys of a prefix") {
  Cache cache(100, length);
  for (const char* key : {"m1/a", "m1/b", "m10/a", "m2", "m"}) put(cache, key, 1);
  cache.erase("m1");  // no such key
  CHECK(cache.stats().entries == 5);
  cache.erase_prefix("m1/");
  CHECK(cache.find("m1/a") == nullptr);
  CHECK(cache.find("m1/b") == nullptr);
  CHECK(cache.find("m10/a") != nullptr);
  CHECK(cache.find("m2") != nullptr);
  cache.erase("m");
  CHECK(cache.find("m") == nullptr);
  CHECK(cache.stats().bytes == 2);
  CHECK(cache.stats().evictions == 0);
}

TEST_CASE("a hundred callers of one missing key make it once") {
  Cache cache(100, length);
  std::latch all_there(100);
  std::vector<std::future<Cache::Pointer>> callers;
  for (int i = 0; i < 100; ++i) {
    callers.push_back(std::async(std::launch::async, [&] {
      all_there.arrive_and_wait();
      const auto got = cache.get_or_create("a", [&]() -> Result<Cache::Pointer> {
        std::this_thread::sleep_for(20ms);
        return std::make_shared<const std::string>("made");
      });
      return got ? got->value : nullptr;
    }));
  }
  const Cache::Pointer first = callers[0].get();
  REQUIRE(first);
  for (std::size_t i = 1; i < callers.size(); ++i) CHECK(callers[i].get() == first);
  CHECK(cache.stats().makes == 1);
}

TEST_CASE("waiters share the maker's error") {
  Cache cache(100, length);
  std::promise<void> go;
  const auto open = go.get_future().share();
  const auto make = [&]() -> Result<Cache::Pointer> {
    open.wait();
    return fail(ErrorCode::mesh_invalid, "broken");
  };
  std::vector<std::future<ErrorCode>> callers;
  for (int i = 0; i < 4; ++i) {
    callers.push_back(std::async(std::launch::async, [&] {
      const auto got = cache.get_or_create("a", make);
      return got ? ErrorCode::internal : got.error().code;
    }));
  }
  wait_until([&] { return cache.stats().waits == 3; });
  go.set_value();
  for (auto& caller : callers) CHECK(caller.get() == ErrorCode::mesh_invalid);
  CHECK(cache.stats().makes == 1);
}

TEST_CASE("when the maker is told to stop or throws, a waiter takes over") {
  for (const std::string how : {"cancelled", "deadline", "throws"}) {
    CAPTURE(how);
    Cache cache(100, length);
    std::promise<void> go;
    auto maker = std::async(std::launch::async, [&]() -> Result<Cache::Lookup> {
      return cache.get_or_create("a", [&]() -> Result<Cache::Pointer> {
        go.get_future().wait();
        if (how == "throws") throw std::runtime_error("x");
        return fail(how == "deadline" ? ServiceCode::deadline : ErrorCode::cancelled, "stopped");
      });
    });
    wait_until([&] { return cache.stats().makes == 1; });
    std::vector<std::future<Result<Cache::Lookup>>> waiters;
    for (int i = 0; i < 3; ++i) {
      waiters.push_back(std::async(std::launch::async,
                                   [&] { return cache.get_or_create("a", making("second")); }));
    }
    wait_until([&] { return cache.stats().waits == 3; });
    go.set_value();
    if (how == "throws") {
      CHECK_THROWS_AS((void)maker.get(), std::runtime_error);
    } else {
      CHECK_FALSE(maker.get());
    }
    for (auto& waiter : waiters) {
      const auto got = waiter.get();
      REQUIRE(got);
      CHECK(*got->value == "second");
    }
    CHECK(cache.stats().makes == 2);
  }
}

TEST_CASE("what was refused to the maker for what it is, a waiter asks for again") {
  for (const ErrorCode code : {ServiceCode::too_many_requests, ServiceCode::overloaded}) {
    CAPTURE(code.name());
    Cache cache(100, length);
    std::promise<void> go;
    auto maker = std::async(std::launch::async, [&] {
      return cache.get_or_create("a", [&]() -> Result<Cache::Pointer> {
        go.get_future().wait();
        return fail(code, "too many computations of this client");
      });
    });
    wait_until([&] { return cache.stats().makes == 1; });
    Caller patient;
    patient.is_patient = true;
    auto job = std::async(std::launch::async,
                          [&] { return cache.get_or_create("a", making("second"), patient); });
    wait_until([&] { return cache.stats().waits == 1; });
    auto other =
        std::async(std::launch::async, [&] { return cache.get_or_create("a", making("second")); });
    wait_until([&] { return cache.stats().waits == 2; });
    go.set_value();
    CHECK(maker.get().error().code == code);
    const auto got = job.get();
    REQUIRE(got);
    CHECK(*got->value == "second");
    // Who may not wait for long has waited as long as the maker did.
    const auto shared = other.get();
    CHECK((shared ? code == ServiceCode::too_many_requests : shared.error().code == code));
  }
}

TEST_CASE("a waiter whose client leaves or whose time is over waits no longer") {
  Cache cache(100, length);
  std::latch made(1);
  auto maker = std::async(std::launch::async, [&] {
    return cache.get_or_create("a", [&]() -> Result<Cache::Pointer> {
      made.wait();
      return std::make_shared<const std::string>("late");
    });
  });
  wait_until([&] { return cache.stats().makes == 1; });
  Caller hasty;
  hasty.deadline = Caller::Clock::now() + 10ms;
  CHECK(cache.get_or_create("a", making("other"), hasty).error().code == ServiceCode::deadline);
  const Caller gone([] { return true; });
  CHECK(cache.get_or_create("a", making("other"), gone).error().code == ErrorCode::cancelled);
  made.count_down();
  CHECK(maker.get());
  CHECK(*cache.find("a") == "late");
}

TEST_CASE("an erase during a flight keeps its result out, for newcomers too") {
  Cache cache(100, length);
  std::promise<void> go;
  auto maker = std::async(std::launch::async, [&] {
    return cache.get_or_create("m/a", [&]() -> Result<Cache::Pointer> {
      go.get_future().wait();
      return std::make_shared<const std::string>("old");
    });
  });
  wait_until([&] { return cache.stats().makes == 1; });
  auto waiter =
      std::async(std::launch::async, [&] { return cache.get_or_create("m/a", making("unused")); });
  wait_until([&] { return cache.stats().waits == 1; });
  cache.erase_prefix("m/");
  const auto newcomer = cache.get_or_create("m/a", making("new"));
  REQUIRE(newcomer);
  CHECK(*newcomer->value == "new");
  go.set_value();
  CHECK(*maker.get()->value == "old");
  CHECK(*waiter.get()->value == "old");
  CHECK(*cache.find("m/a") == "new");
}

TEST_CASE("a value may use the cache while it is made and while it is destroyed") {
  struct Nosy {
    LruCache<Nosy>* cache;
    ~Nosy() { (void)cache->stats(); }  // deadlocks if destroyed under the lock
  };
  LruCache<Nosy> cache(1, [](const Nosy&) { return std::size_t{1}; });
  const auto make = [&]() -> Result<LruCache<Nosy>::Pointer> {
    (void)cache.find("other");
    return std::shared_ptr<const Nosy>(new Nosy{&cache});
  };
  (void)cache.get_or_create("a", make);
  (void)cache.get_or_create("b", make);  // evicts a
  CHECK(cache.stats().evictions == 1);
  cache.erase("b");
  (void)cache.get_or_create("c", make);
  cache.set_budget(0);
  CHECK(cache.stats().entries == 0);
}

TEST_CASE("under stress the books stay balanced and every value belongs to its key") {
  Cache cache(2000, length);
  std::atomic<int> wrong{0};
  std::atomic<std::uint64_t> made{0};
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 8; ++t) {
    threads.emplace_back([&, t] {
      std::uint32_t state = t + 1;
      for (int i = 0; i < 3000; ++i) {
        state = state * 1664525u + 1013904223u;
        const std::uint32_t k = (state >> 8) % 40;
        const std::string key = "k" + std::to_string(k);
        switch ((state >> 16) % 16) {
          case 0:
            cache.erase(key);
            break;
          case 1:
            cache.erase_prefix("k" + std::to_string(k % 4));
            break;
          case 2:
            if (const auto found = cache.find(key)) wrong += found->size() != 50 + k;
            break;
          case 3: {
            const auto got = cache.get_or_create(
                key, []() -> Result<Cache::Pointer> { return fail(ErrorCode::cancelled, ""); });
            if (got) wrong += got->value->size() != 50 + k;
            break;
          }
          case 4:
            try {
              (void)cache.get_or_create(key, []() -> Result<Cache::Pointer> { throw 1; });
            } catch (int) {
            }
            break;
          default: {
            const auto got = cache.get_or_create(key, [&]() -> Result<Cache::Pointer> {
              ++made;
              std::this_thread::yield();
              return std::make_shared<const std::string>(50 + k, 'x');
            });
            if (!got || got->value->size() != 50 + k) ++wrong;
          }
        }
      }
    });
  }
  for (auto& thread : threads) thread.join();
  CHECK(wrong == 0);
  CHECK(made > 100);
  const CacheStats stats = cache.stats();
  CHECK(stats.bytes <= 2000);
  std::uint64_t bytes = 0;
  std::uint64_t entries = 0;
  for (int k = 0; k < 40; ++k) {
    if (const auto found = cache.find("k" + std::to_string(k))) {
      bytes += found->size();
      ++entries;
    }
  }
  CHECK(stats.bytes == bytes);
  CHECK(stats.entries == entries);
  CHECK(stats.evictions > 0);
}
