// The memory of all bodies that are being received or handled. When it does not suffice, one body
// must go: the slowest one of the clients that hold much. So stalled uploads mostly go before those
// that make progress.
//
// A complete body is not taken away. The connection of a body that must go is told so. The body's
// memory no longer counts from then on; it is freed within a tick of the clock of HttpWorkers.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <list>
#include <mutex>
#include <string>
#include <unordered_map>

namespace geodesic::server {

class BodyBudget {
 public:
  using Clock = std::chrono::steady_clock;

  // `most`: bytes; 0: no bound. `memory`: the time over which a body's rate is averaged.
  BodyBudget(std::uint64_t most, std::chrono::milliseconds memory);
  BodyBudget(const BodyBudget&) = delete;
  BodyBudget& operator=(const BodyBudget&) = delete;

  // One body's part. For one thread at a time.
  class Part {
   public:
    // `unwanted` is set, by any thread, when the body must go. Both must outlive it.
    Part(BodyBudget& budget, std::atomic<bool>& unwanted) : budget_(budget), unwanted_(unwanted) {}
    ~Part() { release(); }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    // A client's body begins to be received.
    void begin(const std::string& client, Clock::time_point now = Clock::now());
    // It has `bytes` now, never fewer than before. False if it must go, for lack of room or because
    // another body needs the room.
    [[nodiscard]] bool hold(std::uint64_t bytes, Clock::time_point now = Clock::now());
    // It is complete: from now on nobody takes it away. False if somebody has.
    [[nodiscard]] bool complete();
    // It is no more.
    void release();

   private:
    friend class BodyBudget;
    BodyBudget& budget_;
    std::atomic<bool>& unwanted_;
    // Guarded by the budget's mutex.
    bool is_there_ = false;
    bool is_evicted_ = false;
    std::string client_;
    std::uint64_t bytes_ = 0;
    Clock::time_point begun_;
    Clock::time_point last_;  // when bytes came last
    double recent_ = 0;       // bytes, weighted less the older they are
    std::list<Part*>::iterator place_;
    bool is_received_ = false;  // has a place among those that may go
  };

  [[nodiscard]] std::uint64_t bytes() const { return total_; }

 private:
  [[nodiscard]] double rate(const Part& part, Clock::time_point now) const;
  [[nodiscard]] Part* slowest(Clock::time_point now);
  // Takes what a part holds out of the sums.
  void forget(Part& part);
  void leave(Part& part);

  const std::uint64_t most_;
  const double memory_;  // seconds
  std::mutex mutex_;
  std::list<Part*> received_;  // those that may go
  std::unordered_map<std::string, std::uint64_t> of_client_;
  std::atomic<std::uint64_t> total_{0};
};

}  // namespace geodesic::server
