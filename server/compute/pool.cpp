#include "server/compute/pool.h"

#include <algorithm>
#include <new>

#include "server/base/cores.h"
#include "server/base/memory_trimmer.h"
#include "server/base/run_guarded.h"
#include "server/base/service_codes.h"
#include "server/compute/crew.h"

namespace geodesic::server {

namespace {

std::size_t slots_or_cores(std::size_t slots) { return slots != 0 ? slots : usable_cores(); }

}  // namespace

ComputePool::ComputePool(std::size_t slots, const QueueLimits& limits) : limits_(limits) {
  counts_.slots = slots_or_cores(slots);
  keeps_.resize(counts_.slots);
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

void ComputePool::set_limits(const QueueLimits& limits) {
  const std::lock_guard lock(mutex_);
  limits_ = limits;
}

Result<void> ComputePool::refuse(Error error) {
  ++counts_.rejected;
  return fail(std::move(error));
}

auto ComputePool::expected_wait(const std::string& client) const -> Clock::duration {
  // What waits while a slot is free is about to be taken into it.
  if (busy() + queue_.size() < counts_.slots) return Clock::duration(0);
  // Each slot must end what it runs, half of which is over on average, and then
  // takes its part of the turns before ours.
  const auto turns = static_cast<Clock::rep>(queue_.turns_before(client));
  const auto slots = static_cast<Clock::rep>(counts_.slots);
  return usual_time_ * (2 * turns + slots) / (2 * slots);
}

std::chrono::seconds ComputePool::retry_after(const std::string& client) const {
  const Lock lock(mutex_);
  constexpr std::chrono::seconds kMost{60};
  return std::clamp(std::chrono::ceil<std::chrono::seconds>(expected_wait(client)),
                    std::chrono::seconds(1), kMost);
}

Result<void> ComputePool::admit(const std::shared_ptr<Job>& job, const Caller& caller) {
  if (draining_) return fail(ServiceCode::draining, "the server is about to stop");
  if (caller.deadline_over()) return fail(caller.why_stopped());
  job->is_finishing = caller.is_finishing;
  if (job->is_finishing) {
    queue_.push_ahead(job);
    note_queue();
    call_worker();
    return {};
  }
  const std::size_t own = queue_.size_of(caller.client);
  if (!caller.is_patient && limits_.jobs_of_client != 0 && own >= limits_.jobs_of_client) {
    return refuse(Error{ServiceCode::too_many_requests,
                        "too many computations of this client are waiting",
                        {},
                        limits_.jobs_of_client,
                        own});
  }
  // The estimate counts only where there is a line to stand in: after one slow job,
  // an empty queue must still take the next.
  if (!queue_.empty()) {
    const Clock::duration wait = expected_wait(caller.client);
    const bool too_late = caller.deadline && Clock::now() + wait > *caller.deadline;
    // An estimate may fall short: who would hardly make it had better know now than after
    // waiting.
    const bool too_long = bounds_wait_of(caller) && wait + wait / 4 > limits_.wait;
    if (too_late || too_long) {
      const auto seconds = [](Clock::duration time) {
        return std::to_string(std::chrono::ceil<std::chrono::seconds>(time).count()) + " s";
      };
      const std::string expected = ": about " + seconds(wait) + " to wait";
      return refuse(Error{ServiceCode::overloaded,
                          too_late
                              ? "the queue is longer than the request's deadline allows" + expected
                              : "the queue of computations is too long" + expected +
                                    ", and the server lets nobody wait for more than " +
                                    seconds(limits_.wait) + " (--queue-seconds)",
                          {},
                          {},
                          {}});
    }
  }
  // Jobs that a free worker is about to take do not count as waiting, nor do the few that can
  // wait: they take no place from others, and others none from them.
  const auto may_go = [](const std::shared_ptr<Job>& waiting) { return !waiting->is_patient; };
  const std::size_t impatient = queue_.waiting_for_turn() - patient_;
  if (!caller.is_patient && impatient >= limits_.jobs + (counts_.slots - busy())) {
    if (queue_.longest(may_go) > own + 1) {
      const std::shared_ptr<Job> displaced = queue_.take_from_longest(may_go);
      displaced->outcome = refuse(Error{ServiceCode::too_many_requests,
                                        "the queue is full, and most of it is this client's",
                                        {},
                                        limits_.jobs,
                                        {}});
      displaced->finished = true;
      displaced->finished_signal.notify_one();
    } else {
      // Whoever waits alone has no share to exceed.
      const bool greedy = queue_.clients() > 1 && own * queue_.clients() > queue_.size();
      return refuse(Error{greedy ? ServiceCode::too_many_requests : ServiceCode::overloaded,
                          "the queue of computations is full",
                          {},
                          limits_.jobs,
                          queue_.size()});
    }
  }
  job->is_patient = caller.is_patient;
  if (job->is_patient) ++patient_;
  queue_.push(caller.client, job);
  note_queue();
  call_worker();
  return {};
}

Result<void> ComputePool::run_erased(std::function<void(Worker&)> body, const Caller& caller) {
  const auto job = std::make_shared<Job>();
  job->body = std::move(body);
  Lock lock(mutex_);
  if (auto admitted = admit(job, caller); !admitted) return admitted;
  if (auto ran = wait_for(job, caller, lock); !ran) return ran;
  if (caller.times) caller.times->add(Stage::queue, job->waited);
  return std::move(job->outcome);
}

Result<void> ComputePool::wait_for(const std::shared_ptr<Job>& job, const Caller& caller,
                                   Lock& lock) {
  constexpr std::chrono::milliseconds kPollInterval{50};
  const bool is_wait_bounded = bounds_wait_of(caller);
  const Clock::time_point latest =
      is_wait_bounded ? Clock::now() + limits_.wait : Clock::time_point::max();
  const bool watched = caller.gone || caller.deadline || is_wait_bounded;
  while (!job->finished) {
    if (!watched) {
      job->finished_signal.wait(lock);
      continue;
    }
    auto wake = std::min(latest, caller.deadline.value_or(Clock::time_point::max()));
    if (caller.gone) wake = std::min(wake, Clock::now() + kPollInterval);
    if (job->finished_signal.wait_until(lock, wake) != std::cv_status::timeout) continue;

    std::optional<Error> reason;
    if (caller.deadline_over()) {
      reason = caller.why_stopped();
    } else if (Clock::now() >= latest) {
      reason = Error{ServiceCode::overloaded, "no compute slot became free in time", {}, {}, {}};
    } else if (caller.gone) {
      lock.unlock();  // the question may take a system call
      const bool gone = caller.gone();
      lock.lock();
      if (gone) reason = caller.why_stopped();
    }
    if (!reason || job->finished) continue;
    if (!queue_.erase(caller.client, job)) {
      // It runs, and so refers to the caller's stack.
      wait_for_running(
          job->finished_signal, [&] { return job->finished; }, caller, lock);
      break;
    }
    if (job->is_patient) --patient_;
    note_queue();
    ++(reason->code == ServiceCode::overloaded ? counts_.rejected : counts_.given_up);
    return fail(std::move(*reason));
  }
  return {};
}

void ComputePool::work(std::size_t slot) {
  Worker worker{slot};
  Lock lock(mutex_);
  while (true) {
    std::shared_ptr<Crew> crew;
    Help* helped = nullptr;
    job_ready_.wait(lock, [&] {
      crew = queue_.empty() ? crew_to_help() : nullptr;
      helped = queue_.empty() && !crew ? job_to_help() : nullptr;
      return draining_ || !queue_.empty() || crew || helped || is_to_forget(worker);
    });
    if (queue_.empty() && !crew && !helped) {
      if (draining_) return;  // and nothing is left
      forget_kept(worker, lock);
      continue;
    }
    ++counts_.running;
    if (crew) {
      join_crew(crew, worker, lock);
    } else if (helped) {
      help(*helped, worker, lock);
    } else {
      const std::shared_ptr<Job> job = queue_.pop();
      if (job->is_patient) --patient_;
      note_queue();
      run_job(job, worker, lock);
    }
    if (worker.has_freed_much) {
      worker.has_freed_much = false;
      lock.unlock();
      trim_heaps();  // the C library would keep it for the next job like this one
      lock.lock();
    }
    --counts_.running;
    keeps_[slot] = worker.kept > 0;
    if (waiting_for_room_ > 0) room_.notify_all();
  }
}

void ComputePool::forget_kept(Worker& worker, Lock& lock) {
  ++forgetting_;
  lock.unlock();
  (void)run_counted(worker, [&] {
    worker.memory->lift_limits();
    forget_(worker);
    worker.memory->keep(0);
  });
  trim_heaps();
  lock.lock();
  --forgetting_;
  worker.has_freed_much = false;
  keeps_[worker.slot] = false;  // whatever happened: it is asked once
  room_.notify_all();
}

void ComputePool::run_job(const std::shared_ptr<Job>& job, Worker& worker, Lock& lock) {
  const Clock::time_point begin = Clock::now();
  job->waited = begin - job->queued;
  if (waited_) {
    lock.unlock();
    waited_(job->waited);
    lock.lock();
  }
  if (job->crew) {
    join_crew(job->crew, worker, lock);
  } else {
    lock.unlock();
    Result<void> outcome = run_counted(worker, [&] { job->body(worker); });
    const Clock::duration taken = Clock::now() - begin;
    lock.lock();
    // What finishes a request takes no turn: its time is part of the turn that the request had.
    usual_time_ += (job->is_finishing ? taken : taken - usual_time_) / 16;
    ++counts_.finished;
    job->outcome = std::move(outcome);
  }
  job->finished = true;
  job->finished_signal.notify_one();
}

Result<void> ComputePool::run_counted(Worker& worker, const std::function<void()>& body) {
  std::optional<Error> refusal;
  Result<void> outcome;
  {
    JobMemory memory(memory_, worker.kept);
    worker.memory = &memory;
    outcome = run_guarded([&] {
      try {
        body();
      } catch (const std::bad_alloc&) {
        if (!memory.refusal()) throw;
        refusal = memory.refusal();
      }
    });
    worker.kept = memory.kept();
    worker.has_freed_much = worker.has_freed_much || memory.has_freed_much();
    worker.memory = nullptr;
  }
  if (refusal) return fail(std::move(*refusal));
  return outcome;
}

void ComputePool::drain() {
  {
    const std::lock_guard lock(mutex_);
    draining_ = true;
    call_workers();
    room_.notify_all();
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
  stats.clients = queue_.clients();
  return stats;
}

}  // namespace geodesic::server
