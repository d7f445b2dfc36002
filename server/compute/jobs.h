// Long work apart from connections: a request that its client does not wait for
// becomes a job, which runs on a thread of its own and keeps its reply until it is
// fetched, forgotten or too old. Knows no routes: it runs the handler it is given, on
// the request it is given.
//
//   start()   queued -> running -> done (status below 400) or failed
//   remove()  cancels what is queued or running; forgets what has ended
//
// A job has a lease, unless it is asked to go on without one: it is cancelled once nobody has
// asked about it for so long. Whoever asks renews the lease, and a watcher asks all the time. So
// what a closed page or a killed script has begun does not run on.
//
// Bounds, so that jobs cannot take what connections could not:
//  - so many jobs may wait and run, and so many run at once; more are `overloaded`.
//    No client has more than half of either (`too_many_requests`), and those who wait
//    take turns: who has the fewest running goes first, then who was served longest
//    ago. While it runs, a job queues for compute slots like any request of its client;
//  - the bodies of requests and replies together have a budget in bytes. What has
//    ended is forgotten when it has been kept for long enough, or when the budget is used up:
//    then the oldest of the client whose results take the most. What a job gathers while it
//    runs is charged as it grows.
//
// A job may outlive this process, if a `Keeper` keeps its question and its reply elsewhere. Then
// `stop` hands over what has not ended: it is not told to be cancelled, and another process begins
// it again, or takes over what it came to.
//
// Ids are 128 random bits: to know one is to be allowed to ask for it.
//
// Thread-safe: all methods may be called from any thread but `stop` and the
// destructor from a handler's.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "server/http/message.h"

namespace geodesic::server {

// Whether a job ends when nobody asks about it any more.
enum class JobLease : std::uint8_t { renewed, none };

enum class JobState : std::uint8_t { queued, running, done, failed, cancelled };

[[nodiscard]] std::string_view name_of(JobState state);
[[nodiscard]] constexpr bool has_ended(JobState state) { return state > JobState::running; }

// A job at one moment.
struct JobReport {
  using Time = std::chrono::system_clock::time_point;

  std::string id;
  JobState state = JobState::queued;
  double progress = 0;  // 0 to 1; never less than before
  std::string method;   // of the request
  std::string target;
  Time created;
  std::optional<Time> started;
  std::optional<Time> finished;
  int status = 0;                                  // of the reply; 0: there is none
  std::optional<std::chrono::milliseconds> lease;  // none: it goes on though nobody asks
  std::uint64_t attempt = 1;                       // how often it has been begun, by any process
  bool is_kept = false;  // another process can begin it again, or has what it came to
  bool is_handed_over = false;

  [[nodiscard]] bool operator==(const JobReport&) const = default;
};

// How a job begins.
struct JobBeginning {
  JobLease lease = JobLease::renewed;
  std::string id_begins = {};  // with which 32 random hexadecimal digits make its id
  // Of one that another process has taken.
  std::string id = {};
  std::uint64_t attempt = 1;
  std::optional<JobReport::Time> created = {};
};

class Jobs {
 public:
  using Handler = std::function<HttpResponse(HttpRequest&)>;
  // What keeps jobs for longer than this process lives; all or none are empty. None throws.
  struct Keeper {
    // Before a job can run: whether its question is kept. Called without a lock, as the next one
    // is.
    std::function<bool(const JobReport&, const HttpRequest&)> taken;
    // Before it is told that a job has ended.
    std::function<void(const JobReport&, const HttpResponse&)> ended;
    // What is kept of a job is of no use any more: it was removed, or nobody asked about it. Only
    // notes it, for it is called with a lock.
    std::function<void(const std::string& id)> dropped;
  };

  struct Limits {
    std::size_t jobs = 64;    // that wait or run
    std::size_t running = 4;  // … at once: threads
    std::uint64_t bytes = std::uint64_t{256} << 20;
    std::chrono::milliseconds keep = std::chrono::minutes(10);  // after the end
    std::chrono::milliseconds lease{0};                         // of a job; 0: none has one
  };
  struct Stats {
    std::uint64_t queued = 0;
    std::uint64_t running = 0;
    std::uint64_t ended = 0;  // and not yet forgotten
    std::uint64_t bytes = 0;  // of requests that wait and replies that are kept
    // Since the start.
    std::uint64_t done = 0;
    std::uint64_t failed = 0;
    std::uint64_t cancelled = 0;
    std::uint64_t refused = 0;  // not taken at all
  };

  Jobs(const Limits& limits, Handler handler);
  ~Jobs();  // stops
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  // Takes a request. The handler gets it with another caller: of the same client, gone
  // once the job is cancelled. A job of the same id that is here already stays as it is.
  // Errors: overloaded, too_many_requests, draining.
  [[nodiscard]] Result<JobReport> start(HttpRequest request, JobBeginning how = {});

  // Keeps, for a client, what a job came to elsewhere. Errors: as `start`; too_large.
  [[nodiscard]] Result<JobReport> adopt(JobReport report, HttpResponse reply,
                                        const std::string& client);

  // To be called before any job is begun.
  void set_keeper(Keeper keeper) { keeper_ = std::move(keeper); }

  // Nothing if there is no such job (any more). This and all below that look at a job renew its
  // lease.
  [[nodiscard]] std::optional<JobReport> find(const std::string& id);

  // A job that can be watched to its end, even if it is forgotten meanwhile; null if
  // there is none.
  struct Job;
  using Handle = std::shared_ptr<Job>;
  [[nodiscard]] Handle hold(const std::string& id);
  [[nodiscard]] JobReport report(const Handle& job);
  // The same once it differs from `seen`, or after `patience`. Small steps of progress
  // are told a few times a second.
  [[nodiscard]] JobReport wait_for_news(const Handle& job, const JobReport& seen,
                                        std::chrono::milliseconds patience);

  // The handler's reply. Errors: job_unknown; job_unfinished; job_cancelled; draining, if it was
  // handed over.
  [[nodiscard]] Result<HttpResponse> result(const std::string& id);

  // Cancels a job, or forgets it if it has ended. False if there is none.
  bool remove(const std::string& id);

  // Cancels all jobs, or hands them over, and refuses new ones (`draining`). Idempotent.
  void hand_over();
  // The same; returns when no handler runs any more.
  void stop();

  [[nodiscard]] Stats stats();

 private:
  using Clock = std::chrono::steady_clock;
  struct Share {  // of a client
    std::size_t waiting = 0;
    std::size_t running = 0;
    std::uint64_t served = 0;  // when it last began one, counted in jobs
  };

  [[nodiscard]] Result<void> admit(const std::string& client, std::uint64_t bytes);
  // What has ended makes it, if need be. Errors: too_large, overloaded.
  [[nodiscard]] Result<void> make_room(std::uint64_t bytes);
  void work();
  [[nodiscard]] Handle next_to_run();
  [[nodiscard]] Result<void> have_thread();
  void cancel(const Handle& job);
  void drop(const Job& job);
  void cancel_unwatched();
  void run(Job& job, std::unique_lock<std::mutex>& lock);
  [[nodiscard]] HttpResponse reply_to(Job& job);
  void end(Job& job, JobState state, JobReport::Time finished = std::chrono::system_clock::now());
  void charge(Job& job, std::uint64_t bytes);
  // Charges a job that runs, where there is room. Errors: too_large, overloaded, job_cancelled.
  [[nodiscard]] Result<void> grow(Job& job, std::uint64_t bytes);
  [[nodiscard]] std::uint64_t charged(const Job& job);
  [[nodiscard]] Handle next_to_forget() const;
  void forget(const Handle& job);
  void forget_old();
  [[nodiscard]] static JobReport report_of(const Job& job);
  [[nodiscard]] Handle find_locked(const std::string& id);

  const Limits limits_;
  const Handler handler_;
  Keeper keeper_;

  std::mutex mutex_;
  std::condition_variable work_ready_;
  std::condition_variable changed_;  // some job's state
  std::map<std::string, Handle> jobs_;
  std::list<Handle> waiting_;                  // the oldest first
  std::list<Handle> ended_;                    // likewise; its bytes can be had back
  std::map<std::string, std::uint64_t> kept_;  // bytes of those, by client
  std::map<std::string, Share> shares_;
  std::uint64_t served_ = 0;
  std::size_t being_kept_ = 0;  // before they wait
  std::size_t running_ = 0;     // threads in a handler
  std::uint64_t bytes_ = 0;
  Stats counts_;  // only those since the start
  bool stopping_ = false;
  std::mutex join_mutex_;
  std::vector<std::thread> threads_;
};

}  // namespace geodesic::server
