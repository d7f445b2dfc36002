// The few threads that compute, and the bounded, fair queue in front of them.
//
// Many cheap I/O threads call `run`; as many jobs as there are slots run at
// once, the others queue, and clients take turns (fair_queue.h). A caller blocks
// until its job is done. What cannot be served is refused at once, not let die
// slowly:
//  - a full queue is `overloaded`; but if somebody has more jobs waiting than the
//    newcomer would have, the newest of those is sent away (`too_many_requests`)
//    to make room, so that a greedy client cannot fill the queue for the others;
//  - a job that would not start before its caller's deadline, by what jobs took
//    lately, is `overloaded` too;
//  - a queued job whose deadline passes ends with `deadline`, and one whose client
//    is gone with `cancelled`.
// A job that finishes a request, whose long work is done, is next: it is not refused for the
// queue's length, for then that work would be lost.
// A running job is never interrupted: it polls its caller through its own `Cancel`. One that
// still runs a second after its caller has stopped holds a slot for nobody: that is a fault of
// ours, and is said in the log and counted.
//
// A computation of many parts (`run_each`) queues for one slot as a job does. While it
// has that one, slots that nobody waits for help it; as soon as somebody does, one of
// them gives its part back for later, and between parts all look at the queue. So a
// long table is done by all cores, and delays others no more than a single job.
//
// A job may have the slots that nobody waits for help it (`Help`). They wait for its steps by
// asking again and again (core/base/team.h), and leave it for whatever else is to be done.
//
// Each worker has a slot number, so that scratch memory can be kept per worker
// and used without a lock. What a job allocates counts (compute/memory.h).
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/team.h"
#include "server/base/caller.h"
#include "server/base/stage_times.h"
#include "server/compute/fair_queue.h"
#include "server/compute/memory.h"

namespace geodesic::server {

// The thread a job runs on. `slot` is in 0 … slots-1 and no two jobs that run
// at the same time share one.
struct Worker {
  std::size_t slot;
  JobMemory* memory = nullptr;  // of the job
  std::uint64_t kept = 0;       // bytes that the last job left to the slot
  bool has_freed_much = false;
};

// Whether a part of a computation is to end for now, because somebody waits for its slot.
using GiveWay = std::function<bool()>;

class ComputePool {
 public:
  struct Stats {
    std::uint64_t slots = 0;
    std::uint64_t running = 0;
    std::uint64_t helping = 0;  // of these, what gives way to whoever waits
    std::uint64_t queued = 0;
    std::uint64_t clients = 0;      // that have jobs queued
    std::uint64_t finished = 0;     // jobs, and parts, run to their end since the start
    std::uint64_t rejected = 0;     // for want of room or time, some after having queued
    std::uint64_t given_up = 0;     // taken back by their callers while queued
    std::uint64_t unanswering = 0;  // that run a second after their callers have stopped
    std::uint64_t unanswered = 0;   // how many ever did
  };

  struct QueueLimits {
    std::size_t jobs = 256;          // that may wait; 0: a job is taken only if a slot is free
    std::size_t jobs_of_client = 0;  // … of one client: `too_many_requests`. 0: no bound
    // Longest wait; a job that waited, or would wait, longer is `overloaded`. 0: no bound.
    std::chrono::milliseconds wait{0};
    // None of these holds for callers that are patient, who are few, nor for those that
    // finish a request. Their jobs are not sent away either.
  };

  // `slots` 0: as many as there are usable_cores().
  ComputePool(std::size_t slots, const QueueLimits& limits);
  ComputePool(std::size_t slots, std::size_t max_queued)
      : ComputePool(slots, QueueLimits{max_queued, 0, std::chrono::milliseconds(0)}) {}
  ~ComputePool();  // drains
  ComputePool(const ComputePool&) = delete;
  ComputePool& operator=(const ComputePool&) = delete;

  // Told, by the worker, how long each job has waited for it. To be set before any job.
  void observe_waits(std::function<void(StageTimes::Duration)> waited) {
    waited_ = std::move(waited);
  }

  [[nodiscard]] std::size_t slots() const { return threads_.size(); }

  // In how many seconds a client that was refused may try again: by what waits, 1 to 60.
  [[nodiscard]] std::chrono::seconds retry_after(const std::string& client) const;

  // For jobs to come; those that wait already keep the wait they were promised.
  void set_limits(const QueueLimits& limits);
  // The limit of all jobs together holds at once, those of one job for jobs to come.
  void set_memory_limits(const ComputeMemory::Limits& limits) { memory_.set_limits(limits); }
  [[nodiscard]] ComputeMemory::Stats memory() const { return memory_.stats(); }

  // Runs `job(Worker&)`, which returns Result<R>, on a worker and returns its
  // result. Blocks. Errors of its own: `overloaded` (see above, or the job ran
  // out of memory: both mean "not now"), `too_much_memory`, `too_many_requests`, `draining`,
  // `cancelled` and `deadline` (the caller left or its time passed while queued;
  // asked about every 50 ms) and `internal` (the job threw). A job that reports
  // `cancelled` after its caller's deadline ends with `deadline`. Not to be called
  // from within a job: that could wait for itself.
  template <class Job>
  [[nodiscard]] auto run(Job&& job, const Caller& caller = {})
      -> std::invoke_result_t<Job&, Worker&> {
    CrowdedOut unheeded;
    return run_noting(job, caller, unheeded);
  }

  // The same for a job that may be begun again, from the start: where it has no room beside
  // others, it leaves its slot, and tries again once there is twice what it wanted (but
  // no more than a query may have) or nothing else runs. So it holds nothing while it waits, and
  // nothing waits for it. It is `overloaded` after `kTries`, or once it has waited for room as
  // long as jobs may wait in the queue.
  template <class Job>
  [[nodiscard]] auto run_with_room(Job&& job, const Caller& caller = {})
      -> std::invoke_result_t<Job&, Worker&> {
    for (int tries_left = kTries;;) {
      CrowdedOut out;
      auto answer = run_noting(job, caller, out);
      if (answer || out.wanted == 0 || --tries_left == 0) return answer;
      auto room = wait_for_room(out.wanted, caller);
      if (!room) return fail(std::move(room.error()));
    }
  }

  // Told what forgets the memory that a slot keeps between jobs: called by the slot's own thread
  // while it is idle and somebody waits for room. Empty: none is kept. It is not called any more
  // once another is set.
  void observe_want_of_room(std::function<void(Worker&)> forget) {
    Lock lock(mutex_);
    room_.wait(lock, [this] { return forgetting_ == 0; });
    forget_ = std::move(forget);
  }

  // Runs `part(Worker&, std::size_t i, const GiveWay&)`, which returns Result<void>, for
  // each i below `count`, several at once. Blocks until all are done, or until one has
  // failed and those that run have ended; the error is that of the lowest i that failed.
  // A part asks GiveWay as often as whether it is cancelled, and ends with `cancelled`
  // where it says true: it is run again, so it must leave nothing behind that matters.
  // So is one that has no room beside the others, with a slot less.
  // Errors: those of `run`. Not to be called from within a job.
  template <class Compute>
  [[nodiscard]] Result<void> run_each(std::size_t count, Compute&& part, const Caller& caller) {
    auto done = run_each_erased(count, std::ref(part), caller);
    if (!done && done.error().code == ErrorCode::cancelled && caller.deadline_over()) {
      return fail(caller.why_stopped());
    }
    return done;
  }

  // Idle slots that help the computation of a job, as long as this lives: the job makes it, on its
  // worker, and gives the computation its team. They join at once or later, and leave as soon as
  // anything else is to be done. What they allocate meanwhile counts, but not against the job's own
  // limit, and no longer than they help: lists of a front, which are small. (compute/help.cpp)
  class Help {
   public:
    // `is_worth_it`: else nobody is asked.
    explicit Help(ComputePool& pool, bool is_worth_it = true);
    ~Help();
    Help(const Help&) = delete;
    Help& operator=(const Help&) = delete;

    // Null where no slot is idle at the beginning, for then dividing is not worth it either.
    [[nodiscard]] Team* team() { return team_ ? &*team_ : nullptr; }

   private:
    friend class ComputePool;
    ComputePool& pool_;
    std::optional<Team> team_;
    std::size_t inside_ = 0;  // slots; guarded by the pool's mutex
    std::condition_variable left_;
  };

  // Refuses new jobs (`draining`); those queued or running finish.
  // Returns when all workers have ended. Idempotent.
  void drain();

  [[nodiscard]] Stats stats() const;

 private:
  struct Job;
  struct Crew;
  using Clock = Caller::Clock;
  using Lock = std::unique_lock<std::mutex>;
  static constexpr int kTries = 4;

  // What a job wanted when others held it; 0: nothing was refused for that.
  struct CrowdedOut {
    std::uint64_t wanted = 0;
  };
  // Notes it at the job's end, however that comes.
  class NoteRoom {
   public:
    NoteRoom(const Worker& worker, CrowdedOut& out) : worker_(worker), out_(out) {}
    NoteRoom(const NoteRoom&) = delete;
    NoteRoom& operator=(const NoteRoom&) = delete;
    ~NoteRoom() { out_.wanted = worker_.memory->crowded_out(); }

   private:
    const Worker& worker_;
    CrowdedOut& out_;
  };
  template <class Job>
  [[nodiscard]] auto run_noting(Job&& job, const Caller& caller, CrowdedOut& out)
      -> std::invoke_result_t<Job&, Worker&> {
    using Answer = std::invoke_result_t<Job&, Worker&>;
    std::optional<Answer> answer;
    Result<void> ran = run_erased(
        [&](Worker& worker) {
          const NoteRoom noted(worker, out);
          answer.emplace(job(worker));
          // Whatever it says, that is what it stopped by.
          if (!*answer && worker.memory->refusal()) *answer = fail(*worker.memory->refusal());
        },
        caller);
    if (!ran) return fail(std::move(ran.error()));
    if (!*answer && answer->error().code == ErrorCode::cancelled && caller.deadline_over()) {
      return fail(caller.why_stopped());
    }
    return std::move(*answer);
  }

  Result<void> run_erased(std::function<void(Worker&)> body, const Caller& caller);
  // Waits until a job that was admitted has run, or takes it back.
  Result<void> wait_for(const std::shared_ptr<Job>& job, const Caller& caller, Lock& lock);
  // Waits for what runs and polls its caller itself, until `done()`. (compute/watch.cpp)
  void wait_for_running(std::condition_variable& signal, const std::function<bool()>& done,
                        const Caller& caller, Lock& lock);
  // Takes a job into the queue, or says why not.
  Result<void> admit(const std::shared_ptr<Job>& job, const Caller& caller);
  // How long a job of this client's would wait, by what jobs took lately.
  [[nodiscard]] Clock::duration expected_wait(const std::string& client) const;
  Result<void> refuse(Error error);
  [[nodiscard]] bool bounds_wait_of(const Caller& caller) const {
    return limits_.wait.count() != 0 && !caller.is_patient && !caller.is_finishing;
  }
  // Waits, in no slot, until others have given back enough for a job that has wanted so much,
  // or nothing else runs. Errors: those of waiting in the queue. (compute/watch.cpp)
  Result<void> wait_for_room(std::uint64_t wanted, const Caller& caller);
  [[nodiscard]] bool has_room_for(std::uint64_t wanted) const;
  // An idle slot gives back what it keeps.
  void forget_kept(Worker& worker, Lock& lock);
  [[nodiscard]] bool is_to_forget(const Worker& worker) const {
    return waiting_for_room_ > 0 && keeps_[worker.slot] && forget_;
  }
  void work(std::size_t slot);
  void run_job(const std::shared_ptr<Job>& job, Worker& worker, Lock& lock);
  // Runs what a job, or a part of one, does, and counts its memory.
  [[nodiscard]] Result<void> run_counted(Worker& worker, const std::function<void()>& body);

  // compute/crew.cpp
  using Part = std::function<Result<void>(Worker&, std::size_t, const GiveWay&)>;
  Result<void> run_each_erased(std::size_t count, Part part, const Caller& caller);
  // Works on a crew's parts until there are none left or the slot is wanted.
  void join_crew(const std::shared_ptr<Crew>& crew, Worker& worker, Lock& lock);
  void work_on_parts(Crew& crew, Worker& worker, Lock& lock);
  // The crew that an idle worker should join; null when none needs one.
  [[nodiscard]] std::shared_ptr<Crew> crew_to_help() const;
  [[nodiscard]] bool must_give_way(Crew& crew);
  // Jobs wait, and slots that are free or about to be do not suffice for them.
  [[nodiscard]] bool is_slot_wanted() const {
    return queue_.size() > counts_.slots - counts_.running + giving_way_ + lent_;
  }
  // compute/help.cpp
  // Whom an idle worker should help; null when there is nobody.
  [[nodiscard]] Help* job_to_help() const;
  void help(Help& job, Worker& worker, Lock& lock);
  // There is something to do for a worker that is idle or helps, or for all of them.
  void call_worker() {
    calls_.fetch_add(1, std::memory_order_relaxed);
    job_ready_.notify_one();
  }
  void call_workers() {
    calls_.fetch_add(1, std::memory_order_relaxed);
    job_ready_.notify_all();
  }
  // What runs and does not give way.
  [[nodiscard]] std::uint64_t busy() const { return counts_.running - counts_.helping; }
  void note_queue() { is_queue_empty_.store(queue_.empty(), std::memory_order_relaxed); }

  ComputeMemory memory_;
  mutable std::mutex mutex_;
  std::condition_variable job_ready_;
  FairQueue<std::shared_ptr<Job>> queue_;
  std::size_t patient_ = 0;                   // of these, jobs whose callers are patient
  std::atomic<bool> is_queue_empty_{true};    // to be asked without the mutex
  std::vector<std::shared_ptr<Crew>> crews_;  // that have a slot
  std::size_t giving_way_ = 0;                // slots that will be free in a moment
  std::vector<Help*> helped_;                 // jobs that idle slots may help
  std::size_t lent_ = 0;                      // slots that do
  std::atomic<std::uint64_t> calls_{0};       // of workers: whoever helps leaves at the next one
  std::size_t waiting_for_room_ = 0;          // callers whose jobs were crowded out
  std::condition_variable room_;              // a job has ended, or a slot has forgotten
  std::function<void(Worker&)> forget_;
  std::size_t forgetting_ = 0;  // slots that call it now
  std::vector<bool> keeps_;     // by slot: whether its last job left something to it
  QueueLimits limits_;
  Clock::duration usual_time_{0};  // of a turn: a moving average
  std::function<void(StageTimes::Duration)> waited_;
  bool draining_ = false;
  Stats counts_;
  std::mutex join_mutex_;
  std::vector<std::thread> threads_;
};

}  // namespace geodesic::server
