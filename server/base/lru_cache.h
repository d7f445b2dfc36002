// A cache of immutable, shared values with a budget in bytes.
//
// A value is a `shared_ptr<const Value>`: evicting or erasing one that a query
// holds is harmless, the query keeps it alive and the cache merely forgets it.
// When the budget is exceeded, what was used least recently goes first. An entry
// that alone exceeds the budget is handed out but not kept.
//
// `get_or_create` is single-flight: of any number of threads that ask for the
// same missing key, one runs `make` and the others wait for its result. A
// failed `make` is not cached; every waiter gets the same error, except that
// when the maker was told to stop (`cancelled`, `deadline`) one of the waiters
// makes it in its stead: that a client hung up is nobody else's error. Nor is
// `too_many_requests`, which is of one client. `overloaded` is that of all who
// may not wait for long, and only who is patient goes on. Who waits
// is asked every 50 ms whether it still wants to. `make` may throw; then the
// exception reaches the caller that ran it and a waiter takes over likewise. An
// erase during a flight lets the flight finish for those who wait, but keeps its
// result out of the cache, and a caller that arrives after the erase starts a
// flight of its own.
//
// Thread-safe: all methods may be called from any thread. `make` runs outside
// the lock and may use the cache for other keys, not for its own. Values are
// destroyed outside the lock.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "server/base/caller.h"
#include "server/base/service_codes.h"

namespace geodesic::server {

struct CacheStats {
  std::uint64_t bytes = 0;
  std::uint64_t budget = 0;
  std::uint64_t entries = 0;
  std::uint64_t hits = 0;
  std::uint64_t misses = 0;     // lookups that found nothing, waiters included
  std::uint64_t evictions = 0;  // for want of room; erased entries do not count
  std::uint64_t waits = 0;      // callers that waited for another's flight
  std::uint64_t makes = 0;      // calls of `make`
};

struct CacheEntry {
  std::string key;
  std::uint64_t bytes;
};

template <class Value>
class LruCache {
 public:
  using Pointer = std::shared_ptr<const Value>;
  using SizeOf = std::function<std::size_t(const Value&)>;

  struct Lookup {
    Pointer value;
    bool hit;  // it was in the cache already; false for the maker and for those who waited
  };

  // `budget_bytes` 0 keeps nothing, but single flight still holds.
  // `size_of` gives the bytes of a value; called once for each, outside the lock.
  LruCache(std::uint64_t budget_bytes, SizeOf size_of)
      : budget_(budget_bytes), size_of_(std::move(size_of)) {}
  LruCache(const LruCache&) = delete;
  LruCache& operator=(const LruCache&) = delete;

  // The value of `key`, which becomes the most recently used; null if it is not there.
  [[nodiscard]] Pointer find(const std::string& key);

  // The value of `key`, made by `make` if it is not there.
  // `make` is callable without arguments and returns Result<Pointer>, never a null one.
  // Errors: those of `make`; cancelled and deadline for a caller that waits.
  template <class Make>
  [[nodiscard]] Result<Lookup> get_or_create(const std::string& key, Make&& make,
                                             const Caller& caller = {});

  // Whether `key` is there; leaves its age and the counts as they are.
  [[nodiscard]] bool peek(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    return entries_.contains(key);
  }

  // Forgets `key`, or every key that starts with `prefix`.
  void erase(const std::string& key) { erase_range(key, /*is_prefix=*/false); }
  void erase_prefix(const std::string& prefix) { erase_range(prefix, /*is_prefix=*/true); }

  // Changes the budget and evicts down to it.
  void set_budget(std::uint64_t bytes);

  [[nodiscard]] CacheStats stats() const;

  // What it holds, the most recently used first; `most` of it.
  [[nodiscard]] std::vector<CacheEntry> entries(std::size_t most) const {
    std::vector<CacheEntry> entries;
    const std::lock_guard lock(mutex_);
    for (const Entry& entry : order_) {
      if (entries.size() == most) break;
      entries.push_back({entry.key, entry.bytes});
    }
    return entries;
  }

 private:
  static constexpr std::chrono::milliseconds kAskEvery{50};

  struct Entry {
    std::string key;
    Pointer value;
    std::uint64_t bytes;
  };
  using Order = std::list<Entry>;

  // One `make` under way; listed in `flights_` unless its key was erased.
  // Everything is guarded by the lock until `done`; after that it is immutable.
  struct Flight {
    bool done = false;
    bool abandoned = false;  // the maker was stopped or threw: somebody else has to
    std::optional<Result<Pointer>> result;
    std::condition_variable landed;
  };

  // Whether it is an error that the maker got for what it is, and the waiter might not.
  static bool is_only_its_makers(const Result<Pointer>& result, const Caller& waiter) {
    if (result) return false;
    const ErrorCode code = result.error().code;
    return code == ServiceCode::too_many_requests ||
           (code == ServiceCode::overloaded && waiter.is_patient);
  }

  Pointer find_locked(const std::string& key);
  // Ends a flight; `result` empty: the maker threw. `bytes` is the value's size.
  void land(const std::string& key, const std::shared_ptr<Flight>& flight,
            std::optional<Result<Pointer>> result, std::uint64_t bytes);
  // Moves what is over the budget to `out`, to be destroyed outside the lock.
  void evict_locked(Order& out);
  void erase_range(const std::string& key, bool is_prefix);

  mutable std::mutex mutex_;
  std::uint64_t budget_;
  const SizeOf size_of_;
  std::uint64_t bytes_ = 0;
  Order order_;  // the most recently used first
  // Ordered, so that a prefix is a range.
  std::map<std::string, typename Order::iterator, std::less<>> entries_;
  std::map<std::string, std::shared_ptr<Flight>, std::less<>> flights_;
  CacheStats counts_;
};

// -- Implementation -----------------------------------------------------------

template <class Value>
auto LruCache<Value>::find_locked(const std::string& key) -> Pointer {
  const auto found = entries_.find(key);
  if (found == entries_.end()) {
    ++counts_.misses;
    return nullptr;
  }
  ++counts_.hits;
  order_.splice(order_.begin(), order_, found->second);
  return found->second->value;
}

template <class Value>
auto LruCache<Value>::find(const std::string& key) -> Pointer {
  const std::lock_guard lock(mutex_);
  return find_locked(key);
}

template <class Value>
template <class Make>
auto LruCache<Value>::get_or_create(const std::string& key, Make&& make, const Caller& caller)
    -> Result<Lookup> {
  std::shared_ptr<Flight> flight;
  {
    std::unique_lock lock(mutex_);
    if (Pointer value = find_locked(key)) return Lookup{std::move(value), true};
    while (true) {
      const auto under_way = flights_.find(key);
      if (under_way == flights_.end()) break;  // ours to make
      flight = under_way->second;
      ++counts_.waits;
      while (!flight->landed.wait_for(lock, kAskEvery, [&] { return flight->done; })) {
        lock.unlock();  // the question may take a system call
        const bool given_up = caller();
        lock.lock();
        if (given_up && !flight->done) return fail(caller.why_stopped());
      }
      if (!flight->abandoned && !is_only_its_makers(*flight->result, caller)) {
        if (!*flight->result) return fail(flight->result->error());
        return Lookup{flight->result->value(), false};
      }
      // Somebody may have taken over and landed before this thread woke up.
      if (const auto found = entries_.find(key); found != entries_.end()) {
        return Lookup{found->second->value, false};
      }
    }
    flight = std::make_shared<Flight>();
    flights_.emplace(key, flight);
    ++counts_.makes;
  }

  // Lands the flight whatever happens, so that an exception leaves nobody waiting.
  struct Landing {
    LruCache& cache;
    const std::string& key;
    const std::shared_ptr<Flight>& flight;
    std::optional<Result<Pointer>> result;
    std::uint64_t bytes = 0;
    ~Landing() { cache.land(key, flight, std::move(result), bytes); }
  };
  Landing landing{*this, key, flight, std::nullopt};
  Result<Pointer> result = std::forward<Make>(make)();
  if (result) landing.bytes = size_of_(**result);
  landing.result = result;
  if (!result) return fail(std::move(result.error()));
  return Lookup{std::move(*result), false};
}

template <class Value>
void LruCache<Value>::land(const std::string& key, const std::shared_ptr<Flight>& flight,
                           std::optional<Result<Pointer>> result, std::uint64_t bytes) {
  Order evicted;  // destroyed after the lock is released
  const std::lock_guard lock(mutex_);
  const auto under_way = flights_.find(key);
  const bool keep = under_way != flights_.end() && under_way->second == flight;
  if (keep) flights_.erase(under_way);

  flight->abandoned = !result || (!*result && (result->error().code == ErrorCode::cancelled ||
                                               result->error().code == ServiceCode::deadline));
  if (!flight->abandoned && *result && keep && bytes <= budget_) {
    order_.push_front(Entry{key, **result, bytes});
    entries_.emplace(key, order_.begin());
    bytes_ += bytes;
    evict_locked(evicted);
  }
  flight->result = std::move(result);
  flight->done = true;
  flight->landed.notify_all();
}

template <class Value>
void LruCache<Value>::evict_locked(Order& out) {
  while (bytes_ > budget_) {
    const auto oldest = std::prev(order_.end());
    bytes_ -= oldest->bytes;
    ++counts_.evictions;
    entries_.erase(oldest->key);
    out.splice(out.begin(), order_, oldest);
  }
}

template <class Value>
void LruCache<Value>::erase_range(const std::string& key, bool is_prefix) {
  const auto matches = [&](const std::string& candidate) {
    return is_prefix ? candidate.starts_with(key) : candidate == key;
  };
  Order erased;  // destroyed after the lock is released
  const std::lock_guard lock(mutex_);
  for (auto it = entries_.lower_bound(key); it != entries_.end() && matches(it->first);) {
    bytes_ -= it->second->bytes;
    erased.splice(erased.begin(), order_, it->second);
    it = entries_.erase(it);
  }
  // A flight that is no longer listed still lands for those who wait, but is not kept.
  for (auto it = flights_.lower_bound(key); it != flights_.end() && matches(it->first);) {
    it = flights_.erase(it);
  }
}

template <class Value>
void LruCache<Value>::set_budget(std::uint64_t bytes) {
  Order evicted;
  const std::lock_guard lock(mutex_);
  budget_ = bytes;
  evict_locked(evicted);
}

template <class Value>
CacheStats LruCache<Value>::stats() const {
  const std::lock_guard lock(mutex_);
  CacheStats stats = counts_;
  stats.bytes = bytes_;
  stats.budget = budget_;
  stats.entries = entries_.size();
  return stats;
}

}  // namespace geodesic::server
