// What jobs hold, in bytes, and which of those that have ended is forgotten when that is too much
// or too old.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>

#include "server/base/service_codes.h"
#include "server/compute/job.h"
#include "server/compute/jobs.h"

namespace geodesic::server {

std::uint64_t Jobs::charged(const Job& job) {
  const std::lock_guard lock(mutex_);
  return job.bytes;
}

// While a job runs, what it gathers is charged before it is kept.
Result<void> Jobs::grow(Job& job, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (has_ended(job.report.state)) return fail(ServiceCode::job_cancelled, "the job was cancelled");
  if (bytes > limits_.bytes) {  // at no time
    return fail_limit(ErrorCode::too_large, kTooLargeToKeep, limits_.bytes, bytes);
  }
  while (bytes_ - job.bytes + bytes > limits_.bytes && !ended_.empty()) forget(next_to_forget());
  if (bytes_ - job.bytes + bytes > limits_.bytes) {
    return fail_limit(ServiceCode::overloaded, "the jobs' replies take all of their memory",
                      limits_.bytes, bytes_ - job.bytes + bytes);
  }
  charge(job, bytes);
  return {};
}

Result<JobReport> Jobs::adopt(JobReport report, HttpResponse reply, const std::string& client) {
  const auto job = std::make_shared<Job>();
  const std::uint64_t bytes = (reply.body ? reply.body->size() : 0) + kBytesOfJob;
  job->report = std::move(report);
  job->report.status = reply.status;
  job->client = client;
  job->reply = std::move(reply);
  const std::lock_guard lock(mutex_);
  cancel_unwatched();
  forget_old();
  if (const auto known = jobs_.find(job->report.id); known != jobs_.end()) {
    return report_of(*known->second);
  }
  if (stopping_) return fail(ServiceCode::draining, "the server is about to stop");
  if (auto room = make_room(bytes); !room) return fail(std::move(room.error()));
  jobs_.emplace(job->report.id, job);
  charge(*job, bytes);
  const Stats counts = counts_;
  end(*job, job->reply.status < 400 ? JobState::done : JobState::failed,
      job->report.finished.value_or(job->report.created));
  counts_ = counts;  // who ran it has counted it
  return report_of(*job);
}

void Jobs::charge(Job& job, std::uint64_t bytes) {
  bytes_ += bytes - job.bytes;
  if (job.is_kept) kept_[job.client] += bytes - job.bytes;
  job.bytes = bytes;
}

void Jobs::end(Job& job, JobState state, JobReport::Time finished) {
  ++(state == JobState::done     ? counts_.done
     : state == JobState::failed ? counts_.failed
                                 : counts_.cancelled);
  job.report.state = state;
  job.report.finished = finished;
  job.forgotten_at = Clock::now() + limits_.keep;
  if (const auto kept = jobs_.find(job.report.id); kept != jobs_.end()) {
    ended_.push_back(kept->second);
    job.is_kept = true;
    kept_[job.client] += job.bytes;
  }
  changed_.notify_all();
  while (bytes_ > limits_.bytes && ended_.size() > 1) forget(next_to_forget());
}

void Jobs::forget(const Handle& job) {
  // `job` may be the list's own.
  const Handle held = job;  // NOLINT(performance-unnecessary-copy-initialization)
  // What still runs, cancelled, keeps its charge until it has given its body back.
  if (!held->is_running) charge(*held, 0);
  jobs_.erase(held->report.id);
  ended_.remove(held);
  if (held->is_kept) {
    const auto kept = kept_.find(held->client);
    kept->second -= held->bytes;
    held->is_kept = false;
    if (kept->second == 0) kept_.erase(kept);
  }
  changed_.notify_all();
}

// The oldest of the client whose results take the most: nobody pushes out what others have left.
auto Jobs::next_to_forget() const -> Handle {
  const auto most = std::max_element(
      kept_.begin(), kept_.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto first = std::find_if(ended_.begin(), ended_.end(), [&](const Handle& job) {
    return most == kept_.end() || job->client == most->first;
  });
  return first != ended_.end() ? *first : ended_.front();
}

void Jobs::forget_old() {
  const Clock::time_point now = Clock::now();
  while (!ended_.empty() && ended_.front()->forgotten_at <= now) forget(ended_.front());
}

}  // namespace geodesic::server
