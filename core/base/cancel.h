// How a running computation learns that its answer is no longer wanted or takes too much
// memory, and how it tells how far it has come. Core has no clock and no sockets: whoever
// starts a computation says what ends it (a deadline, a client that hung up, a process that
// stops, a budget), who hears of its progress and which threads help it.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "core/base/error.h"
#include "core/base/memory_budget.h"

namespace geodesic {

class Team;

class Cancel {
 public:
  Cancel() = default;  // never
  // The budget and the team must outlive this; null: any amount, and nobody.
  explicit Cancel(std::function<bool()> poll, std::function<void(double)> progress = {},
                  MemoryBudget* memory = nullptr, Team* team = nullptr)
      : poll_(std::move(poll)), progress_(std::move(progress)), memory_(memory), team_(team) {}

  // True once the computation should stop. Asked every few thousand steps, by
  // the computing thread.
  [[nodiscard]] bool requested() const {
    return (memory_ != nullptr && memory_->refusal()) || (poll_ && poll_());
  }

  // Whoever helps the computation (base/team.h), or null.
  [[nodiscard]] Team* team() const { return team_; }

  // The same for a computation that this team helps; null: nobody does. It must outlive that.
  [[nodiscard]] Cancel helped_by(Team* team) const {
    Cancel helped = *this;
    helped.team_ = team;
    return helped;
  }

  // The budget of the computation, or null.
  [[nodiscard]] MemoryBudget* memory() const { return memory_; }
  // Whether so many bytes more may be taken; if not, the computation should stop.
  [[nodiscard]] bool may_take(std::uint64_t bytes) const {
    return memory_ == nullptr || memory_->may_take(bytes);
  }

  // What a computation that stopped ends with.
  [[nodiscard]] Error why_stopped() const {
    if (memory_ != nullptr && memory_->refusal()) return *memory_->refusal();
    return {ErrorCode::cancelled, "the computation was cancelled", {}, {}, {}};
  }

  // Tells which fraction of the computation is done, from 0 to 1. Called by the computing
  // thread, about as often as `requested`.
  void report(double done) const {
    if (progress_) progress_(done);
  }

  // A Cancel for one of several computations. Its progress counts as the part from `begin` to
  // `end` of the whole. This Cancel must outlive it.
  [[nodiscard]] Cancel part(double begin, double end) const {
    Cancel part(poll_, {}, memory_, team_);
    if (progress_) {
      part.progress_ = [this, begin, end](double done) { report(begin + (end - begin) * done); };
    }
    return part;
  }

 private:
  std::function<bool()> poll_;
  std::function<void(double)> progress_;
  MemoryBudget* memory_ = nullptr;
  Team* team_ = nullptr;
};

// The error of a computation that was told to stop, whatever told it.
[[nodiscard]] inline tl::unexpected<Error> fail_stopped(const Cancel& cancel) {
  return fail(cancel.why_stopped());
}

// Asks a Cancel once in so many steps, counted over all functions that share this Poll.
class Poll {
 public:
  explicit Poll(const Cancel& cancel, std::uint32_t steps_between = 4096)
      : cancel_(cancel), steps_between_(steps_between), left_(steps_between) {}

  // True once the computation should stop, and ever after.
  [[nodiscard]] bool cancelled() { return --left_ == 0 && ask(); }

  // The same for so many steps at once: for a list that is gone through without a question.
  [[nodiscard]] bool cancelled_after(std::uint64_t steps) {
    if (steps >= left_) return ask();
    left_ -= static_cast<std::uint32_t>(steps);
    return stopped_;
  }

  // The same for a loop that has done `done` of about `total` steps before them. It reports as often
  // as it would ask alone, though it may be others that share this Poll who ask.
  [[nodiscard]] bool cancelled_after(std::uint64_t steps, std::uint64_t done, std::uint64_t total) {
    untold_ += steps;
    if (untold_ >= steps_between_ && total != 0) {
      cancel_.report(static_cast<double>(done) / static_cast<double>(total));
      untold_ = 0;
    }
    return cancelled_after(steps);
  }

  // The same in a loop that has done `done` of about `total` steps of its computation. Reports
  // progress only when it asks, so it costs no more.
  [[nodiscard]] bool cancelled(std::uint64_t done, std::uint64_t total) {
    if (--left_ != 0) return false;
    if (total != 0) cancel_.report(static_cast<double>(done) / static_cast<double>(total));
    return ask();
  }

  // Asks at once: for a loop whose steps take as long as thousands of others.
  [[nodiscard]] bool ask() {
    stopped_ = stopped_ || cancel_.requested();
    left_ = stopped_ ? 1 : steps_between_;
    return stopped_;
  }

  // Whether so many more bytes may be taken. If not, the computation should stop. To be asked
  // before they are taken.
  [[nodiscard]] bool may_take(std::uint64_t bytes) {
    if (stopped_ || cancel_.may_take(bytes)) return !stopped_;
    stopped_ = true;
    left_ = 1;
    return false;
  }
  [[nodiscard]] MemoryBudget* memory() const { return cancel_.memory(); }
  [[nodiscard]] Team* team() const { return cancel_.team(); }
  [[nodiscard]] Error why_stopped() const { return cancel_.why_stopped(); }

  // Whether it has been told to stop; asks nobody.
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  const Cancel& cancel_;
  std::uint32_t steps_between_;
  std::uint32_t left_;
  std::uint64_t untold_ = 0;
  bool stopped_ = false;
};

[[nodiscard]] inline tl::unexpected<Error> fail_stopped(const Poll& poll) {
  return fail(poll.why_stopped());
}

}  // namespace geodesic
