// The few threads that compute, and the bounded queue in front of them.
//
// Many cheap I/O threads call `run`; as many jobs as there are slots run at
// once, the others queue. A full queue is an error at once (`overloaded`), not a
// slow death. A caller blocks until its job is done; while the job is still
// queued, a caller whose client is gone takes it back (`cancelled`). A running
// job is never interrupted: it polls its own `Cancel`.
//
// Each worker has a slot number, so that scratch memory can be kept per worker
// and used without a lock.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.h"

namespace geodesic::server {

// The thread a job runs on. `slot` is in 0 … slots-1 and no two jobs that run
// at the same time share one.
struct Worker {
  std::size_t slot;
};

class ComputePool {
 public:
  struct Stats {
    std::uint64_t slots = 0;
    std::uint64_t running = 0;
    std::uint64_t queued = 0;
    std::uint64_t finished = 0;  // jobs run to their end since the start
    std::uint64_t rejected = 0;  // for want of room in the queue
    std::uint64_t given_up = 0;  // taken back by their callers while queued
  };

  // `slots` 0: as many as the machine has cores. `max_queued` jobs may wait;
  // with 0, a job is taken only if a slot is free.
  ComputePool(std::size_t slots, std::size_t max_queued);
  ~ComputePool();  // drains
  ComputePool(const ComputePool&) = delete;
  ComputePool& operator=(const ComputePool&) = delete;

  [[nodiscard]] std::size_t slots() const { return threads_.size(); }

  // Runs `job(Worker&)`, which returns Result<R>, on a worker and returns its
  // result. Blocks. Errors of its own: `overloaded` (queue full, or the job ran
  // out of memory: both mean "not now"), `draining`, `cancelled` (`client_gone`
  // was true while queued; asked about every 50 ms) and `internal` (the job
  // threw). `client_gone` must not throw. Not to be called from within a job:
  // that could wait for itself.
  template <class Job>
  [[nodiscard]] auto run(Job&& job, const std::function<bool()>& client_gone = {})
      -> std::invoke_result_t<Job&, Worker&> {
    using Answer = std::invoke_result_t<Job&, Worker&>;
    std::optional<Answer> answer;
    Result<void> ran =
        run_erased([&](Worker& worker) { answer.emplace(job(worker)); }, client_gone);
    if (!ran) return fail(std::move(ran.error()));
    return std::move(*answer);
  }

  // Refuses new jobs (`draining`); those queued or running finish.
  // Returns when all workers have ended. Idempotent.
  void drain();

  [[nodiscard]] Stats stats() const;

 private:
  struct Job;
  Result<void> run_erased(std::function<void(Worker&)> body,
                          const std::function<bool()>& client_gone);
  void work(std::size_t slot);

  mutable std::mutex mutex_;
  std::condition_variable job_ready_;
  std::deque<std::shared_ptr<Job>> queue_;
  const std::size_t max_queued_;
  bool draining_ = false;
  Stats counts_;
  std::mutex join_mutex_;
  std::vector<std::thread> threads_;
};

}  // namespace geodesic::server
