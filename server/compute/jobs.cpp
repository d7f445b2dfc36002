#include "server/compute/jobs.h"

#include <openssl/rand.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <exception>
#include <new>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "server/base/service_codes.h"
#include "server/compute/job.h"

namespace geodesic::server {

namespace {

// How often who waits for news looks for progress.
constexpr std::chrono::milliseconds kLookEvery{100};

std::string random_digits() {
  std::array<unsigned char, 16> bits{};
  if (RAND_bytes(bits.data(), static_cast<int>(bits.size())) != 1) {
    throw std::runtime_error("no random numbers");
  }
  std::string id;
  for (const unsigned char byte : bits) {
    id += "0123456789abcdef"[byte >> 4U];
    id += "0123456789abcdef"[byte & 15U];
  }
  return id;
}

tl::unexpected<Error> fail_handed_over() {
  return fail(ServiceCode::draining,
              "the server is about to stop; another one goes on with the job");
}

// No client may have more than this of so many.
std::size_t half(std::size_t count) { return (count + 1) / 2; }

}  // namespace

std::string_view name_of(JobState state) {
  constexpr std::array<std::string_view, 5> kNames{"queued", "running", "done", "failed",
                                                   "cancelled"};
  return kNames[static_cast<std::size_t>(state)];
}

Jobs::Jobs(const Limits& limits, Handler handler) : limits_(limits), handler_(std::move(handler)) {}

Jobs::~Jobs() { stop(); }

JobReport Jobs::report_of(const Job& job) {
  JobReport report = job.report;
  report.progress = report.state == JobState::done ? 1 : job.progress.load();
  return report;
}

auto Jobs::find_locked(const std::string& id) -> Handle {
  cancel_unwatched();
  forget_old();
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return nullptr;
  found->second->renew_lease();
  return found->second;
}

Result<void> Jobs::admit(const std::string& client, std::uint64_t bytes) {
  if (stopping_) return fail(ServiceCode::draining, "the server is about to stop");
  const std::size_t all = waiting_.size() + being_kept_ + running_;
  if (all >= limits_.jobs) {
    return fail_limit(ServiceCode::overloaded, "too many jobs wait and run", limits_.jobs, all);
  }
  const auto share = shares_.find(client);
  const std::size_t own =
      share == shares_.end() ? 0 : share->second.waiting + share->second.running;
  if (own >= half(limits_.jobs)) {
    return fail_limit(ServiceCode::too_many_requests, "too many jobs of this client wait and run",
                      half(limits_.jobs), own);
  }
  return make_room(bytes);
}

Result<void> Jobs::make_room(std::uint64_t bytes) {
  if (bytes > limits_.bytes) {  // at no time
    return fail_limit(ErrorCode::too_large, "it is larger than all memory for jobs", limits_.bytes,
                      bytes);
  }
  // What has ended makes room for what is wanted.
  while (bytes_ + bytes > limits_.bytes && !ended_.empty()) forget(next_to_forget());
  if (bytes_ + bytes > limits_.bytes) {
    return fail_limit(ServiceCode::overloaded, "the jobs' requests take all of their memory",
                      limits_.bytes, bytes_ + bytes);
  }
  return {};
}

// A thread for one job more, unless there are as many as may be. With at least one, a job can wait.
Result<void> Jobs::have_thread() {
  const std::size_t wanted = waiting_.size() + being_kept_ + running_ + 1;
  if (threads_.size() >= limits_.running || threads_.size() >= wanted) return {};
  try {
    threads_.emplace_back([this] { work(); });
  } catch (const std::system_error& error) {
    if (threads_.empty()) return fail(ServiceCode::overloaded, "no thread for a job");
    spdlog::warn("a job waits for another's thread: {}", error.what());
  }
  return {};
}

Result<JobReport> Jobs::start(HttpRequest request, JobBeginning how) {
  const auto job = std::make_shared<Job>();
  job->report.id = how.id.empty() ? how.id_begins + random_digits() : std::move(how.id);
  job->report.method = request.method;
  job->report.target = request.target;
  job->report.created = how.created.value_or(std::chrono::system_clock::now());
  job->report.attempt = how.attempt;
  if (how.lease == JobLease::renewed && limits_.lease.count() > 0) {
    job->report.lease = limits_.lease;
  }
  job->renew_lease();
  job->client = request.caller.client;
  const std::uint64_t bytes = request.body.size() + kBytesOfJob;
  // The job outlives the connection: nothing of its caller may stay but what it is called.
  auto asked = std::move(request.caller.asked);
  request.caller = Caller();
  request.caller.asked = std::move(asked);
  request.caller.client = job->client;
  request.caller.is_patient = true;
  // The request is a part of the job, so these may point to it.
  request.caller.gone = [raw = job.get()] { return raw->is_given_up(); };
  request.caller.progress = [raw = job.get()](double done) { raw->advance(done); };
  job->request = std::move(request);

  std::unique_lock lock(mutex_);
  cancel_unwatched();
  forget_old();
  if (const auto known = jobs_.find(job->report.id); known != jobs_.end()) {
    return report_of(*known->second);
  }
  auto admitted = admit(job->client, bytes);
  if (admitted) admitted = have_thread();
  if (!admitted) {
    ++counts_.refused;
    return fail(std::move(admitted.error()));
  }
  jobs_.emplace(job->report.id, job);
  ++shares_[job->client].waiting;
  charge(*job, bytes);
  if (keeper_.taken) {
    const JobReport report = report_of(*job);
    ++being_kept_;
    job->is_being_kept = true;
    lock.unlock();
    const bool is_kept = keeper_.taken(report, job->request);
    lock.lock();
    job->is_being_kept = false;
    --being_kept_;
    job->report.is_kept = is_kept;
    job->renew_lease();                  // however long that took
    if (has_ended(job->report.state)) {  // meanwhile
      job->request.body = {};
      if (!job->report.is_handed_over) drop(*job);
      if (stopping_ && !is_kept) return fail(ServiceCode::draining, "the server is about to stop");
      return report_of(*job);
    }
  }
  waiting_.push_back(job);
  work_ready_.notify_one();
  return report_of(*job);
}

// The next one to run; null if none may.
auto Jobs::next_to_run() -> Handle {
  cancel_unwatched();
  auto next = waiting_.end();
  const Share* best = nullptr;
  for (auto job = waiting_.begin(); job != waiting_.end(); ++job) {
    const Share& share = shares_[(*job)->client];
    if (share.running >= half(limits_.running)) continue;
    if (best != nullptr &&
        std::pair(share.running, share.served) >= std::pair(best->running, best->served)) {
      continue;
    }
    best = &share;
    next = job;
  }
  if (next == waiting_.end()) return nullptr;
  Handle job = std::move(*next);
  waiting_.erase(next);
  return job;
}

void Jobs::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    Handle job;
    work_ready_.wait(lock, [&] { return stopping_ || (job = next_to_run()) != nullptr; });
    if (!job) return;
    Share& share = shares_[job->client];
    --share.waiting;
    ++share.running;
    share.served = ++served_;
    ++running_;
    run(*job, lock);
    --running_;
    if (--share.running + share.waiting == 0) shares_.erase(job->client);
    work_ready_.notify_all();  // its client may run another one now
  }
}

// Runs it without the lock.
void Jobs::run(Job& job, std::unique_lock<std::mutex>& lock) {
  job.report.state = JobState::running;
  job.is_running = true;
  job.report.started = std::chrono::system_clock::now();
  JobReport report = report_of(job);
  changed_.notify_all();
  lock.unlock();
  HttpResponse reply = reply_to(job);
  job.request.body = {};
  report.finished = std::chrono::system_clock::now();
  const std::uint64_t size = reply.body ? reply.body->size() : 0;
  if (keeper_.ended && !job.is_given_up()) {
    (void)grow(job,
               size + kBytesOfJob);  // where there is room; it counts in any case once it ended
    keeper_.ended(report, reply);
  }
  lock.lock();
  job.is_running = false;
  if (has_ended(job.report.state)) {  // cancelled meanwhile
    if (!job.report.is_handed_over) drop(job);
    return charge(job, 0);
  }
  if (job.cancelled) {  // its lease is over
    drop(job);
    charge(job, kBytesOfJob);
    return end(job, JobState::cancelled);
  }
  job.report.status = reply.status;
  job.reply = std::move(reply);
  charge(job, size + kBytesOfJob);
  end(job, job.reply.status < 400 ? JobState::done : JobState::failed, *report.finished);
}

// Never throws. A stream becomes a body.
HttpResponse Jobs::reply_to(Job& job) {
  const auto problem = [&](ErrorCode code, const char* detail) {
    return HttpResponse::problem(Error{code, detail, {}, {}, {}}, job.request);
  };
  try {
    HttpResponse reply = handler_(job.request);
    const std::uint64_t most = limits_.bytes - std::min(limits_.bytes, kBytesOfJob);
    if (reply.stream) {
      std::string body;
      std::string chunk;
      const std::uint64_t before = charged(job);
      const std::uint64_t least = reply.stream_bytes;
      if (auto room = grow(job, before + least); !room) {
        return HttpResponse::problem(room.error(), job.request);
      }
      while (body.size() <= most && reply.stream(chunk)) {
        if (auto room =
                grow(job, before + std::max<std::uint64_t>(least, body.size() + chunk.size()));
            !room) {
          return HttpResponse::problem(room.error(), job.request);
        }
        body += chunk;
        chunk.clear();
      }
      if (reply.broken && *reply.broken) return HttpResponse::problem(**reply.broken, job.request);
      // Both keep what the rows came from, which is not in the job's bytes.
      reply.stream = nullptr;
      reply.broken = nullptr;
      reply.body = std::make_shared<const std::string>(std::move(body));
    }
    if (!reply.body || reply.body->size() <= most) return reply;
    return HttpResponse::problem(
        Error{ErrorCode::too_large, kTooLargeToKeep, {}, most, reply.body->size()}, job.request);
  } catch (const std::bad_alloc&) {
    spdlog::error("{} a job ran out of memory", job.request.id);
    return problem(ServiceCode::overloaded, "out of memory");
  } catch (const std::exception& thrown) {
    spdlog::error("{} a job threw: {}", job.request.id, thrown.what());
  } catch (...) {
    spdlog::error("{} a job threw something that is no exception", job.request.id);
  }
  return problem(ErrorCode::internal, "internal error");
}

std::optional<JobReport> Jobs::find(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const Handle job = find_locked(id);
  if (!job) return std::nullopt;
  return report_of(*job);
}

auto Jobs::hold(const std::string& id) -> Handle {
  const std::lock_guard lock(mutex_);
  return find_locked(id);
}

JobReport Jobs::report(const Handle& job) {
  const std::lock_guard lock(mutex_);
  job->renew_lease();
  return report_of(*job);
}

JobReport Jobs::wait_for_news(const Handle& job, const JobReport& seen,
                              std::chrono::milliseconds patience) {
  const Clock::time_point begin = Clock::now();
  const Clock::time_point end = begin + patience;
  std::unique_lock lock(mutex_);
  while (true) {
    job->renew_lease();
    JobReport now = report_of(*job);
    const Clock::time_point time = Clock::now();
    const bool is_new = now.state != seen.state || (now != seen && time - begin >= kLookEvery);
    if (is_new || time >= end) return now;
    changed_.wait_until(lock, std::min(end, time + kLookEvery));
  }
}

Result<HttpResponse> Jobs::result(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const Handle job = find_locked(id);
  if (!job) return fail(ServiceCode::job_unknown, "no job of this id is kept");
  switch (job->report.state) {
    case JobState::queued:
    case JobState::running:
      return fail(ServiceCode::job_unfinished, "the job has not ended yet");
    case JobState::cancelled:
      if (job->report.is_handed_over) return fail_handed_over();
      return fail(ServiceCode::job_cancelled,
                  job->is_unwatched ? "the job was cancelled, because nobody asked about it; with "
                                      "\"Prefer: respond-async, keep\" it would have gone on"
                                    : "the job was cancelled and has no result");
    case JobState::done:
    case JobState::failed:
      break;
  }
  return job->reply;
}

bool Jobs::remove(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const Handle job = find_locked(id);
  if (!job) return false;
  drop(*job);
  if (has_ended(job->report.state)) {
    forget(job);
    return true;
  }
  cancel(job);
  return true;
}

// A job that has not ended.
void Jobs::cancel(const Handle& job) {
  // `job` may be the list's own.
  const Handle held = job;  // NOLINT(performance-unnecessary-copy-initialization)
  held->cancelled = true;
  if (held->report.state == JobState::queued) {
    waiting_.remove(held);
    const auto share = shares_.find(held->client);
    if (--share->second.waiting + share->second.running == 0) shares_.erase(share);
    if (!held->is_being_kept) held->request.body = {};
    charge(*held, kBytesOfJob);
  }
  end(*held, JobState::cancelled);
}

// Those that wait. The handlers of those that run ask for themselves.
void Jobs::cancel_unwatched() {
  std::vector<Handle> unwatched;
  for (const Handle& job : waiting_) {
    if (job->lease_is_over()) unwatched.push_back(job);
  }
  for (const Handle& job : unwatched) {
    cancel(job);
    drop(*job);
  }
}

void Jobs::drop(const Job& job) {
  if (keeper_.dropped) keeper_.dropped(job.report.id);
}

void Jobs::hand_over() {
  const std::lock_guard lock(mutex_);
  stopping_ = true;
  const std::map<std::string, Handle> jobs = jobs_;  // what ends may push out others
  for (const auto& [id, job] : jobs) {
    if (has_ended(job->report.state)) continue;
    job->cancelled = true;
    job->report.is_handed_over = job->report.is_kept || job->is_being_kept;
    end(*job, JobState::cancelled);
  }
  waiting_.clear();
  work_ready_.notify_all();
  changed_.notify_all();
}

void Jobs::stop() {
  hand_over();
  const std::lock_guard lock(join_mutex_);
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

Jobs::Stats Jobs::stats() {
  const std::lock_guard lock(mutex_);
  cancel_unwatched();
  forget_old();
  Stats stats = counts_;
  stats.queued = waiting_.size() + being_kept_;
  stats.running = running_;
  stats.ended = ended_.size();
  stats.bytes = bytes_;
  return stats;
}

}  // namespace geodesic::server
