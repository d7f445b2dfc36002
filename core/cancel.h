// How a running computation learns that its answer is no longer wanted. Core
// has no clock and no sockets: whoever starts a computation says what ends it
// (a deadline, a client that hung up, a process that stops).
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

namespace geodesic {

class Cancel {
 public:
  Cancel() = default;  // never
  explicit Cancel(std::function<bool()> poll) : poll_(std::move(poll)) {}

  // True once the computation should stop. Asked every few thousand steps, by
  // the computing thread.
  [[nodiscard]] bool requested() const { return poll_ && poll_(); }

 private:
  std::function<bool()> poll_;
};

// Asks a Cancel once in so many steps of a loop, however many functions share it.
class Poll {
 public:
  explicit Poll(const Cancel& cancel, std::uint32_t steps_between = 4096)
      : cancel_(cancel), steps_between_(steps_between), left_(steps_between) {}

  // True once the computation should stop; false again at the next step.
  [[nodiscard]] bool cancelled() {
    if (--left_ != 0) return false;
    left_ = steps_between_;
    return cancel_.requested();
  }

 private:
  const Cancel& cancel_;
  std::uint32_t steps_between_;
  std::uint32_t left_;
};

}  // namespace geodesic
