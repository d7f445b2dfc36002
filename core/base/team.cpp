#include "core/base/team.h"

#include <thread>
#include <utility>

namespace geodesic {
namespace {

constexpr unsigned kHalf = 32;  // bits

// Between two looks at what another thread changes. At first there is no pause, for it would be a
// large part of a short wait. Who has looked often lets other threads go first: the one that is
// waited for may have no core.
void pause_after(std::uint32_t looks) {
  constexpr std::uint32_t kLooksAtOnce = 512;
  constexpr std::uint32_t kLooks = 1 << 14;
  if (looks < kLooksAtOnce) return;
  if (looks % kLooks == 0) {
    std::this_thread::yield();
    return;
  }
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("isb");
#endif
}

constexpr std::uint32_t kLooksBetweenQuestions = 1024;
// So long the computing thread leaves a part to whoever did it in the last step: a microsecond.
constexpr std::uint32_t kLooksBeforeOthers = 600;

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
  const auto step = static_cast<std::uint32_t>(step_.load(std::memory_order_relaxed) >> kHalf) + 1;
  step_.store(std::uint64_t{step} << kHalf | parts, std::memory_order_release);
  if (begin(0, step)) do_part(0, step, poll);
  // More parts than threads belong to nobody.
  for (auto part = static_cast<std::uint32_t>(threads_); part < parts; ++part) {
    if (begin(part, step)) do_part(part, step, poll);
  }
  for (std::uint32_t part = 0; part < parts; ++part) {
    for (std::uint32_t looks = 1; places_[part].done.load(std::memory_order_acquire) != step;
         ++looks) {
      if (looks > kLooksBeforeOthers && begin(part, step)) {
        do_part(part, step, poll);
        break;
      }
      if (looks % kLooksBetweenQuestions == 0 && poll.cancelled()) {
        is_stopped_.store(true, std::memory_order_relaxed);
      }
      pause_after(looks);
    }
  }
  if (has_thrown_.load(std::memory_order_relaxed)) {
    has_thrown_.store(false, std::memory_order_relaxed);
    std::rethrow_exception(std::exchange(thrown_, nullptr));
  }
}

void Team::help(const std::function<bool()>& leave) {
  const Cancel stopped([this] { return is_stopped_.load(std::memory_order_relaxed); });
  Poll poll(stopped);
  const std::uint32_t own = 1 + came_.fetch_add(1, std::memory_order_relaxed);
  helping_.fetch_add(1, std::memory_order_relaxed);
  std::uint32_t last = 0;  // step that was looked through
  for (std::uint32_t looks = 1; !is_over_.load(std::memory_order_relaxed); ++looks) {
    const std::uint64_t seen = step_.load(std::memory_order_acquire);
    const auto step = static_cast<std::uint32_t>(seen >> kHalf);
    if (step != last) {
      last = step;
      const auto parts = static_cast<std::uint32_t>(seen);
      for (std::uint32_t i = 0; i < parts; ++i) {
        const std::uint32_t part = (own + i) % parts;
        if (begin(part, step)) do_part(part, step, poll);
      }
      looks = 0;
      if (leave()) break;
      continue;
    }
    if (looks % kLooksBetweenQuestions == 0 && leave()) break;
    pause_after(looks);
  }
  helping_.fetch_sub(1, std::memory_order_relaxed);
}

}  // namespace geodesic
