// One job: what `Jobs` keeps of it from its start until it is forgotten.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <string>

#include "server/compute/jobs.h"
#include "server/http/message.h"

namespace geodesic::server {

// What a job costs besides bodies, generously: its request's head, its reply's.
inline constexpr std::uint64_t kBytesOfJob = 4096;

inline constexpr const char* kTooLargeToKeep =
    "the reply is too large to be kept: ask for a part of it, such as fewer rows, or for the reply "
    "itself, not a job";

// Guarded by the registry's mutex, but for `request`, which is the thread's once the
// job runs, and what is atomic.
struct Jobs::Job {
  JobReport report;
  HttpRequest request;
  std::string client;
  HttpResponse reply;
  Clock::time_point forgotten_at;
  std::uint64_t bytes = 0;     // charged
  bool is_kept = false;        // it has ended, and its bytes count among its client's
  bool is_running = false;     // its handler is, perhaps after the job was cancelled
  bool is_being_kept = false;  // the keeper reads its request
  std::atomic<bool> cancelled{false};
  std::atomic<bool> is_unwatched{false};  // it was cancelled because nobody asked about it
  std::atomic<Clock::time_point> lease_ends{Clock::time_point::max()};
  std::atomic<double> progress{0};

  void renew_lease() {
    if (report.lease) lease_ends = Clock::now() + *report.lease;
  }
  // From when the lease is found to be over, nobody can renew it.
  bool lease_is_over() {
    if (Clock::now() < lease_ends.load()) return false;
    is_unwatched = true;
    cancelled = true;
    return true;
  }
  // What its handler asks.
  bool is_given_up() { return cancelled.load() || lease_is_over(); }

  void advance(double done) {
    double known = progress.load();
    done = std::min(done, 1.0);
    while (done > known && !progress.compare_exchange_weak(known, done)) {
    }
  }
};

}  // namespace geodesic::server
