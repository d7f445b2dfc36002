// What a ComputePool queues and runs: a job, or a place in a crew. All of it is guarded
// by the pool's mutex, except for what is computed, which belongs to the workers once it
// has left the queue.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "server/compute/pool.h"

namespace geodesic::server {

// A computation of many parts.
struct ComputePool::Crew {
  Part part;
  std::size_t count = 0;
  std::size_t next = 0;                // the first part that nobody has begun
  std::vector<std::size_t> postponed;  // begun, and given back
  std::size_t left = 0;                // parts not done
  std::size_t slots = 0;               // that work on it
  std::size_t giving_way = 0;          // of these
  std::size_t most = SIZE_MAX;         // slots that there is memory for
  std::optional<Error> error;          // of the lowest part that failed
  std::size_t failed = 0;
  std::condition_variable alone;  // no slot works on it any more

  [[nodiscard]] bool has_parts() const { return !error && (!postponed.empty() || next < count); }
  // Only if it has parts.
  std::size_t take() {
    if (postponed.empty()) return next++;
    const std::size_t i = postponed.back();
    postponed.pop_back();
    return i;
  }
};

// Has a body or a crew.
struct ComputePool::Job {
  std::function<void(Worker&)> body;
  std::shared_ptr<Crew> crew;
  Clock::time_point queued = Clock::now();
  Clock::duration waited{0};
  std::condition_variable finished_signal;
  bool is_patient = false;    // its caller's
  bool is_finishing = false;  // its caller's
  bool finished = false;
  Result<void> outcome;
};

}  // namespace geodesic::server
