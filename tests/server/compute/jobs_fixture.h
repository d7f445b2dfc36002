// Jobs by themselves, with handlers that end when the test lets them.
#pragma once

#include <doctest/doctest.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/compute/jobs.h"

namespace geodesic::server::test {

using namespace std::chrono_literals;

inline constexpr auto kJobPatience = 60s;  // far more than any of this takes

// Handlers of paths that begin with "/hold" wait here until they are let go, or cancelled.
class Gate {
 public:
  HttpResponse operator()(HttpRequest& request) {
    std::unique_lock lock(mutex_);
    begun_.push_back(request.path);
    changed_.notify_all();
    while (request.path.starts_with("/hold") && !open_.contains(request.path)) {
      changed_.wait_for(lock, 2ms);
      if (request.caller()) return answer(499, "");
    }
    lock.unlock();
    if (request.path == "/throw") throw std::runtime_error("a secret of the inside");
    if (request.path == "/fail") return answer(422, "no");
    return answer(200, request.body.empty() ? "of " + request.path : request.body);
  }
  void let_go(const std::string& path) {
    const std::lock_guard lock(mutex_);
    open_.insert(path);
    changed_.notify_all();
  }
  // The paths of the handlers that have begun, once there are so many.
  std::vector<std::string> begun(std::size_t count) {
    std::unique_lock lock(mutex_);
    REQUIRE(changed_.wait_for(lock, kJobPatience, [&] { return begun_.size() >= count; }));
    return begun_;
  }
  static HttpResponse answer(int status, std::string body) {
    HttpResponse response;
    response.status = status;
    response.set_body(std::move(body), "text/plain");
    return response;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::string> begun_;
  std::set<std::string> open_;
};

// The job once it has ended.
inline JobReport ended(Jobs& jobs, const std::string& id) {
  const auto job = jobs.hold(id);
  REQUIRE(job);
  JobReport report = jobs.report(job);
  const auto end = std::chrono::steady_clock::now() + kJobPatience;
  while (!has_ended(report.state)) {
    REQUIRE(std::chrono::steady_clock::now() < end);
    report = jobs.wait_for_news(job, report, 1s);
  }
  return report;
}

struct JobsFixture {
  explicit JobsFixture(Jobs::Limits limits = {}) : jobs(limits, std::ref(gate)) {}

  Result<JobReport> try_start(const std::string& path, const std::string& client = "",
                              std::string body = "", JobLease lease = JobLease::renewed) {
    HttpRequest request;
    request.method = "POST";
    request.path = request.target = path;
    request.id = "test";
    request.caller.client = client;
    request.body = std::move(body);
    return jobs.start(std::move(request), {.lease = lease});
  }
  std::string start(const std::string& path, const std::string& client = "",
                    std::string body = "") {
    const auto job = try_start(path, client, std::move(body));
    REQUIRE(job);
    CHECK(job->state == JobState::queued);
    return job->id;
  }
  // The job once it is in that state, or in one that it cannot leave.
  JobReport wait_for(const std::string& id, JobState state) {
    const auto job = jobs.hold(id);
    REQUIRE(job);
    JobReport report = jobs.report(job);
    const auto end = std::chrono::steady_clock::now() + kJobPatience;
    while (report.state != state && !has_ended(report.state)) {
      REQUIRE(std::chrono::steady_clock::now() < end);
      report = jobs.wait_for_news(job, report, 1s);
    }
    CHECK(report.state == state);
    return report;
  }

  Gate gate;
  Jobs jobs;
};

inline Jobs::Limits limits_of(std::size_t jobs, std::size_t running) {
  Jobs::Limits limits;
  limits.jobs = jobs;
  limits.running = running;
  return limits;
}

}  // namespace geodesic::server::test
