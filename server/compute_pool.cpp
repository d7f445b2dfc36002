#include "server/compute_pool.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <new>
#include <string>

namespace geodesic::server {

// Guarded by the pool's mutex, except for `body`, which belongs to the worker
// once the job has left the queue.
struct ComputePool::Job {
  std::function<void(Worker&)> body;
  std::condition_variable finished_signal;
  bool finished = false;
  Result<void> outcome;
};

namespace {

std::size_t slots_or_cores(std::size_t slots) {
  return slots != 0 ? slots : std::max<std::size_t>(1, std::thread::hardware_concurrency());
}

Result<void> run_guarded(const std::function<void(Worker&)>& body, Worker& worker) {
  try {
    body(worker);
    return {};
  } catch (const std::bad_alloc&) {
    // Memory is a resource like a free slot: the same job may do well later.
    spdlog::error("a job ran out of memory");
    return fail(ErrorCode::overloaded, "out of memory");
  } catch (const std::exception& thrown) {
    spdlog::error("a job threw: {}", thrown.what());
  } catch (...) {
    spdlog::error("a job threw something that is no exception");
  }
  return fail(ErrorCode::internal, "internal error");
}

}  // namespace

ComputePool::ComputePool(std::size_t slots, std::size_t max_queued) : max_queued_(max_queued) {
  counts_.slots = slots_or_cores(slots);
  threads_.reserve(counts_.slots);
  try {
    for (std::size_t slot = 0; slot < counts_.slots; ++slot) {
      threads_.emplace_back([this, slot] { work(slot); });
    }
  } catch (...) {
    drain();  // a thread could not be started: end those that were
    throw;
  }
}

ComputePool::~ComputePool() { drain(); }

Result<void> ComputePool::run_erased(std::function<void(Worker&)> body,
                                     const std::function<bool()>& client_gone) {
  const auto job = std::make_shared<Job>();
  job->body = std::move(body);

  std::unique_lock lock(mutex_);
  if (draining_) return fail(ErrorCode::draining, "the server is about to stop");
  // Jobs that a free worker is about to take do not count as waiting.
  if (queue_.size() >= max_queued_ + (counts_.slots - counts_.running)) {
    ++counts_.rejected;
    return fail_limit(ErrorCode::overloaded, "the queue of computations is full", max_queued_,
                      queue_.size());
  }
  queue_.push_back(job);
  job_ready_.notify_one();

  constexpr std::chrono::milliseconds poll_interval{50};
  while (!job->finished) {
    if (!client_gone) {
      job->finished_signal.wait(lock);
      continue;
    }
    if (job->finished_signal.wait_for(lock, poll_interval) != std::cv_status::timeout) continue;
    lock.unlock();  // the question may take a system call
    const bool gone = client_gone();
    lock.lock();
    if (!gone) continue;
    const auto position = std::find(queue_.begin(), queue_.end(), job);
    if (position == queue_.end()) {
      // It runs, and so refers to the caller's stack: wait for it. It polls
      // the same question itself.
      job->finished_signal.wait(lock, [&] { return job->finished; });
      break;
    }
    queue_.erase(position);
    ++counts_.given_up;
    return fail(ErrorCode::cancelled, "the client is gone");
  }
  return std::move(job->outcome);
}

void ComputePool::work(std::size_t slot) {
  Worker worker{slot};
  std::unique_lock lock(mutex_);
  while (true) {
    job_ready_.wait(lock, [&] { return draining_ || !queue_.empty(); });
    if (queue_.empty()) return;  // draining, and nothing left
    const std::shared_ptr<Job> job = std::move(queue_.front());
    queue_.pop_front();
    ++counts_.running;
    lock.unlock();

    Result<void> outcome = run_guarded(job->body, worker);

    lock.lock();
    --counts_.running;
    ++counts_.finished;
    job->outcome = std::move(outcome);
    job->finished = true;
    job->finished_signal.notify_one();
  }
}

void ComputePool::drain() {
  {
    const std::lock_guard lock(mutex_);
    draining_ = true;
    job_ready_.notify_all();
  }
  const std::lock_guard lock(join_mutex_);
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

ComputePool::Stats ComputePool::stats() const {
  const std::lock_guard lock(mutex_);
  Stats stats = counts_;
  stats.queued = queue_.size();
  return stats;
}

}  // namespace geodesic::server
