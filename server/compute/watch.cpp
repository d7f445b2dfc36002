// Who waits for a computation also sees whether it ends once nobody wants it any more; and waits
// for the memory that it needs.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>

#include "server/base/service_codes.h"
#include "server/compute/pool.h"
#include "server/http/request_log.h"

namespace geodesic::server {
namespace {

// A computation asks every few thousand steps whether to stop, so it ends within milliseconds.
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

bool ComputePool::has_room_for(std::uint64_t wanted) const {
  // It may want more when it comes so far again, and is not to come here every time.
  const ComputeMemory::Limits limits = memory_.limits();
  const std::uint64_t most = limits.query != 0 ? limits.query : limits.all;
  if (memory_.has_room(std::max(wanted, std::min(2 * wanted, most)))) return true;
  const bool all_forgotten =
      !forget_ || std::find(keeps_.begin(), keeps_.end(), true) == keeps_.end();
  return counts_.running == 0 && all_forgotten;
}

Result<void> ComputePool::wait_for_room(std::uint64_t wanted, const Caller& caller) {
  const Error crowded{ServiceCode::overloaded,
                      "other computations hold the memory that this one needs",
                      {},
                      memory_.limits().all,
                      wanted};
  Lock lock(mutex_);
  // They are as many threads as those that wait in the queue may be.
  if (waiting_for_room_ >= limits_.jobs) return fail(crowded);
  const Clock::time_point latest =
      bounds_wait_of(caller) ? Clock::now() + limits_.wait : Clock::time_point::max();
  ++waiting_for_room_;
  call_workers();  // idle slots keep memory, too
  Result<void> waited;
  while (waited && !draining_ && !has_room_for(wanted)) {
    room_.wait_until(lock, std::min(latest, Clock::now() + kPollInterval));
    lock.unlock();  // the question may take a system call
    if (caller()) {
      waited = fail(caller.why_stopped());
    } else if (Clock::now() >= latest) {
      waited = fail(crowded);
    }
    lock.lock();
  }
  if (--waiting_for_room_ == 0) call_workers();  // slots may help again
  return waited;
}

}  // namespace geodesic::server
