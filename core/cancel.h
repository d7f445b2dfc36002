// How a running computation learns that its answer is no longer wanted, and how it
// tells how far it has come. Core has no clock and no sockets: whoever starts a
// computation says what ends it (a deadline, a client that hung up, a process that
// stops) and who hears of its progress.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

namespace geodesic {

class Cancel {
 public:
  Cancel() = default;  // never
  explicit Cancel(std::function<bool()> poll, std::function<void(double)> progress = {})
      : poll_(std::move(poll)), progress_(std::move(progress)) {}

  // True once the computation should stop. Asked every few thousand steps, by
  // the computing thread.
  [[nodiscard]] bool requested() const { return poll_ && poll_(); }

  // Tells which part of the computation is done, from 0 to 1; on the computing
  // thread, about as often as `requested` is asked.
  void report(double done) const {
    if (progress_) progress_(done);
  }

  // For one of several computations, which is the part from `begin` to `end` of
  // them all. This one must outlive it.
  [[nodiscard]] Cancel part(double begin, double end) const {
    Cancel part(poll_);
    if (progress_) {
      part.progress_ = [this, begin, end](double done) { report(begin + (end - begin) * done); };
    }
    return part;
  }

 private:
  std::function<bool()> poll_;
  std::function<void(double)> progress_;
};

// Asks a Cancel once in so many steps of a loop, however many functions share it.
class Poll {
 public:
  explicit Poll(const Cancel& cancel, std::uint32_t steps_between = 4096)
      : cancel_(cancel), steps_between_(steps_between), left_(steps_between) {}

  // True once the computation should stop, and ever after.
  [[nodiscard]] bool cancelled() { return --left_ == 0 && ask(); }

  // The same in a loop that has done `done` of about `total` steps of its
  // computation. Costs no more: it is told only when it asks.
  [[nodiscard]] bool cancelled(std::uint64_t done, std::uint64_t total) {
    if (--left_ != 0) return false;
    if (total != 0) cancel_.report(static_cast<double>(done) / static_cast<double>(total));
    return ask();
  }

  // The same at once: beside a step as long as thousands.
  [[nodiscard]] bool ask() {
    stopped_ = stopped_ || cancel_.requested();
    left_ = stopped_ ? 1 : steps_between_;
    return stopped_;
  }

  // Whether it has been told to stop; asks nobody.
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  const Cancel& cancel_;
  std::uint32_t steps_between_;
  std::uint32_t left_;
  bool stopped_ = false;
};

}  // namespace geodesic
