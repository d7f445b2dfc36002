// Idle slots that help a job which computes.
#include <vector>

#include "server/compute/pool.h"

namespace geodesic::server {

ComputePool::Help::Help(ComputePool& pool, bool is_worth_it) : pool_(pool) {
  if (!is_worth_it) return;
  const Lock lock(pool_.mutex_);
  const std::size_t idle = pool_.counts_.slots - pool_.counts_.running + pool_.lent_;
  if (idle == 0 || !pool_.queue_.empty()) return;
  team_.emplace(1 + idle);
  pool_.helped_.push_back(this);
  // Those that help another job leave it, and look for the one with the fewest.
  pool_.call_workers();
}

ComputePool::Help::~Help() {
  if (!team_) return;
  Lock lock(pool_.mutex_);
  std::erase(pool_.helped_, this);
  team_->end();
  left_.wait(lock, [this] { return inside_ == 0; });
}

auto ComputePool::job_to_help() const -> Help* {
  // Idle slots are to forget what they keep.
  if (waiting_for_room_ > 0) return nullptr;
  Help* least = nullptr;
  for (Help* const job : helped_) {
    if (!job->team_->is_over() && (least == nullptr || job->inside_ < least->inside_)) least = job;
  }
  return least;
}

void ComputePool::help(Help& job, Worker& worker, Lock& lock) {
  ++job.inside_;
  ++lent_;
  ++counts_.helping;
  const std::uint64_t calls = calls_.load(std::memory_order_relaxed);
  lock.unlock();
  // What the job's parts throw is thrown by the job.
  (void)run_counted(worker, [&] {
    // It is little. The job itself is refused when there is no room.
    worker.memory->lift_limits();
    job.team_->help([&] { return calls_.load(std::memory_order_relaxed) != calls; });
  });
  lock.lock();
  --counts_.helping;
  --lent_;
  if (--job.inside_ == 0) job.left_.notify_one();
}

}  // namespace geodesic::server
