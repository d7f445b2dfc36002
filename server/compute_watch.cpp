// Who waits for a computation also sees whether it ends once nobody wants it any more.
#include <spdlog/spdlog.h>

#include <optional>

#include "server/compute_pool.h"
#include "server/request_log.h"

namespace geodesic::server {
namespace {

// What computes is asked every few thousand steps, so it answers within milliseconds.
constexpr std::chrono::seconds kAnswersWithin{1};
constexpr std::chrono::milliseconds kPollInterval{50};

std::string name_of(const Caller& caller) {
  if (!caller.asked) return "- a computation";
  return fmt::format("{} {} {}", caller.asked->id, for_log(caller.asked->method),
                     for_log(caller.asked->target));
}

double seconds_since(Caller::Clock::time_point begin) {
  return std::chrono::duration<double>(Caller::Clock::now() - begin).count();
}

}  // namespace

void ComputePool::wait_for_running(std::condition_variable& signal,
                                   const std::function<bool()>& done, const Caller& caller,
                                   Lock& lock) {
  if (!caller.gone && !caller.deadline) return signal.wait(lock, done);
  std::optional<Clock::time_point> stopped;
  while (!done() && !stopped) {
    auto wake = caller.deadline.value_or(Clock::time_point::max());
    if (caller.gone) wake = std::min(wake, Clock::now() + kPollInterval);
    if (signal.wait_until(lock, wake, done)) return;
    lock.unlock();  // the question may take a system call
    if (caller()) stopped = Clock::now();
    lock.lock();
  }
  if (!stopped || signal.wait_until(lock, *stopped + kAnswersWithin, done)) return;
  ++counts_.unanswering;
  ++counts_.unanswered;
  lock.unlock();
  spdlog::error("{} still computes {:.1f} s after it was cancelled: its slot is lost until it ends",
                name_of(caller), seconds_since(*stopped));
  lock.lock();
  signal.wait(lock, done);
  --counts_.unanswering;
  lock.unlock();
  spdlog::warn("{} has ended {:.1f} s after it was cancelled: its slot is free again",
               name_of(caller), seconds_since(*stopped));
  lock.lock();
}

}  // namespace geodesic::server
