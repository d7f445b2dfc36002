// The part of the compute pool that spreads one computation over several slots.
#include "server/compute/crew.h"

#include <algorithm>
#include <utility>

namespace geodesic::server {

Result<void> ComputePool::run_each_erased(std::size_t count, Part part, const Caller& caller) {
  const auto crew = std::make_shared<Crew>();
  crew->part = std::move(part);
  crew->count = crew->left = count;
  // What has begun and gave way is not sent away for the queue's length.
  Caller begun = caller;
  begun.is_patient = true;
  Lock lock(mutex_);
  for (const Caller* asks = &caller; crew->left > 0 && !crew->error; asks = &begun) {
    // One slot as a job gets it; the rest come by themselves, or not at all.
    const auto job = std::make_shared<Job>();
    job->crew = crew;
    if (auto admitted = admit(job, *asks); !admitted) return admitted;
    if (auto ran = wait_for(job, *asks, lock); !ran) return ran;
    wait_for_running(
        crew->alone, [&] { return crew->slots == 0; }, caller, lock);
    if (caller.times) caller.times->add(Stage::queue, job->waited);  // nobody else does now
    if (!job->outcome) return std::move(job->outcome);               // sent away
  }
  if (crew->error) return fail(std::move(*crew->error));
  return {};
}

void ComputePool::join_crew(const std::shared_ptr<Crew>& crew, Worker& worker, Lock& lock) {
  // One slot stays, so that parts are always being done; all others give way.
  if (++crew->slots == 1) {
    crews_.push_back(crew);
  } else {
    ++counts_.helping;
  }
  work_on_parts(*crew, worker, lock);
  if (--crew->slots > 0) {
    --counts_.helping;
    return;
  }
  // What is left is asked for again, by whoever waits for the crew.
  std::erase(crews_, crew);
  crew->alone.notify_one();
}

void ComputePool::work_on_parts(Crew& crew, Worker& worker, Lock& lock) {
  bool gives_way = false;
  const GiveWay give_way = [&] { return gives_way || (gives_way = must_give_way(crew)); };
  while (crew.has_parts()) {
    const std::size_t i = crew.take();
    if (crew.has_parts()) call_worker();  // another that is idle begins the next
    lock.unlock();
    const Clock::time_point begin = Clock::now();
    Result<void> outcome;
    CrowdedOut crowded;
    Result<void> ran = run_counted(worker, [&] {
      const NoteRoom noted(worker, crowded);
      outcome = crew.part(worker, i, give_way);
      if (!outcome && worker.memory->refusal()) outcome = fail(*worker.memory->refusal());
    });
    if (ran) ran = std::move(outcome);
    const Clock::duration taken = Clock::now() - begin;
    lock.lock();
    if (gives_way) {
      --crew.giving_way;
      --giving_way_;
    }
    if (ran) {
      --crew.left;
      ++counts_.finished;
      usual_time_ += (taken - usual_time_) / 16;
    } else if (gives_way && ran.error().code == ErrorCode::cancelled) {
      crew.postponed.push_back(i);
    } else if (crowded.wanted != 0 && crew.slots > 1) {
      // The others go on, and do it when one of them has room.
      crew.postponed.push_back(i);
      crew.most = crew.slots - 1;
      return;
    } else if (!crew.error || i < crew.failed) {
      crew.error = std::move(ran.error());
      crew.failed = i;
    }
    // At least one part to each turn in the queue.
    if (gives_way || is_slot_wanted()) return;
  }
}

bool ComputePool::must_give_way(Crew& crew) {
  // Asked by all that compute, all the time.
  if (is_queue_empty_.load(std::memory_order_relaxed)) return false;
  const std::lock_guard lock(mutex_);
  if (!is_slot_wanted() || crew.slots - crew.giving_way < 2) return false;
  ++crew.giving_way;
  ++giving_way_;
  return true;
}

auto ComputePool::crew_to_help() const -> std::shared_ptr<Crew> {
  std::shared_ptr<Crew> least;
  for (const std::shared_ptr<Crew>& crew : crews_) {
    if (crew->has_parts() && crew->slots < crew->most && (!least || crew->slots < least->slots))
      least = crew;
  }
  return least;
}

}  // namespace geodesic::server
