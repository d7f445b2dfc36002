#include "core/base/team.h"

#include <chrono>
#include <optional>
#include <thread>
#include <utility>

namespace geodesic {
namespace {

using Clock = std::chrono::steady_clock;

constexpr unsigned kHalf = 32;  // bits

// Of waiting for another thread. At first there is no pause between two looks, for it would be a
// large part of a short wait. Who has waited long lets other threads go first, for the one that is
// waited for may have no core; and after a millisecond, in which a computation has had nothing to
// divide, sleeps a little at a time.
class Wait {
 public:
  // Between two looks.
  void pause() {
    ++looks_;
    if (looks_ < kLooksAtOnce) return;
    if (!is_long_ && looks_ % kLooksOfClock == 0) is_long_ = so_far() > kLong;
    if (is_long_) {
      if (so_far() > kVeryLong) return std::this_thread::sleep_for(kSleep);
      return std::this_thread::yield();
    }
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("isb");
#endif
  }
  // True now and then, at first after about a microsecond.
  [[nodiscard]] bool is_to_ask() const {
    return is_long_ || looks_ % kLooksAtOnce == kLooksAtOnce - 1;
  }
  [[nodiscard]] Clock::duration so_far() const { return Clock::now() - begin_; }

 private:
  static constexpr std::uint32_t kLooksAtOnce = 512;
  static constexpr std::uint32_t kLooksOfClock = 64;
  static constexpr std::chrono::microseconds kLong{50};
  static constexpr std::chrono::microseconds kVeryLong{1000};
  static constexpr std::chrono::microseconds kSleep{50};

  Clock::time_point begin_ = Clock::now();
  std::uint32_t looks_ = 0;
  bool is_long_ = false;
};

// A part that takes so much longer than what the computing thread did meanwhile was begun by a
// thread that has lost its core. Once the computing thread has waited for such parts for more than
// this share of what it has worked itself, and for longer than one turn of another process, it goes
// on alone.
constexpr std::int64_t kLate = 300'000;    // nanoseconds
constexpr std::int64_t kTurn = 4'000'000;  // likewise
constexpr int kShareOfWork = 4;

std::int64_t nanoseconds(Clock::duration time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time).count();
}

// In the order in which they were counted, which comes round.
bool is_before(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) < 0; }

}  // namespace

bool Team::begin(std::uint32_t part, std::uint32_t step) {
  std::atomic<std::uint32_t>& begun = places_[part].begun;
  std::uint32_t last = begun.load(std::memory_order_relaxed);
  // Of a later step when whoever asks comes late.
  return is_before(last, step) &&
         begun.compare_exchange_strong(last, step, std::memory_order_acquire);
}

void Team::do_part(std::uint32_t part, std::uint32_t step, Poll& poll) noexcept {
  try {
    call_(work_.data(), part, poll);
  } catch (...) {
    if (!has_thrown_.exchange(true)) thrown_ = std::current_exception();
  }
  if (poll.stopped()) is_stopped_.store(true, std::memory_order_relaxed);
  places_[part].done.store(step, std::memory_order_release);
}

void Team::share(std::uint32_t parts, Poll& poll) {
  const auto begin_of_step = Clock::now();
  const auto step = static_cast<std::uint32_t>(step_.load(std::memory_order_relaxed) >> kHalf) + 1;
  step_.store(std::uint64_t{step} << kHalf | parts, std::memory_order_release);
  if (begin(0, step)) do_part(0, step, poll);
  // More parts than threads belong to nobody.
  for (auto part = static_cast<std::uint32_t>(threads_); part < parts; ++part) {
    if (begin(part, step)) do_part(part, step, poll);
  }
  const std::int64_t own_time = nanoseconds(Clock::now() - begin_of_step);
  worked_ += own_time;
  // The first one too: whoever helps may have been quicker.
  for (std::uint32_t part = 0; part < parts; ++part) {
    bool is_own = false;
    Wait wait;
    while (places_[part].done.load(std::memory_order_acquire) != step) {
      wait.pause();
      if (!wait.is_to_ask()) continue;
      // It was left to whoever did it in the last step, for a microsecond.
      if (begin(part, step)) {
        do_part(part, step, poll);
        is_own = true;
        break;
      }
      if (poll.ask()) is_stopped_.store(true, std::memory_order_relaxed);
    }
    if (is_own) continue;
    if (const std::int64_t waited = nanoseconds(wait.so_far()); waited > kLate + 2 * own_time) {
      waited_ += waited;
      if (waited_ > kTurn + worked_ / kShareOfWork) end();
    }
  }
  // The budget is asked by the computing thread alone: after the step, for all that they have
  // taken.
  if (const std::uint64_t taken = taken_.load(std::memory_order_relaxed); taken > asked_for_) {
    asked_for_ = taken;
    (void)poll.may_take(taken);
  }
  if (has_thrown_.load(std::memory_order_relaxed)) {
    has_thrown_.store(false, std::memory_order_relaxed);
    std::rethrow_exception(std::exchange(thrown_, nullptr));
  }
}

void Team::help(const std::function<bool()>& leave) {
  MemoryBudget counting([this](std::uint64_t bytes) -> std::optional<Error> {
    taken_.fetch_add(bytes, std::memory_order_relaxed);
    return std::nullopt;
  });
  const Cancel stopped([this] { return is_stopped_.load(std::memory_order_relaxed); }, {},
                       &counting);
  Poll poll(stopped);
  const std::uint32_t own = 1 + came_.fetch_add(1, std::memory_order_relaxed);
  helping_.fetch_add(1, std::memory_order_relaxed);
  std::uint32_t last = 0;  // step that was looked through
  Wait wait;
  while (!is_over_.load(std::memory_order_relaxed)) {
    const std::uint64_t seen = step_.load(std::memory_order_acquire);
    const auto step = static_cast<std::uint32_t>(seen >> kHalf);
    if (step == last) {
      if (wait.is_to_ask() && leave()) break;
      wait.pause();
      continue;
    }
    last = step;
    const auto parts = static_cast<std::uint32_t>(seen);
    bool is_leaving = false;
    for (std::uint32_t i = 0; i < parts && !is_leaving; ++i) {
      const std::uint32_t part = (own + i) % parts;
      if (!begin(part, step)) continue;
      do_part(part, step, poll);
      // Where there are more parts than threads they may be long.
      is_leaving = parts > threads_ && leave();
    }
    if (is_leaving || leave()) break;
    wait = Wait();
  }
  helping_.fetch_sub(1, std::memory_order_relaxed);
}

}  // namespace geodesic
