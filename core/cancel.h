// How a running computation learns that its answer is no longer wanted. Core
// has no clock and no sockets: whoever starts a computation says what ends it
// (a deadline, a client that hung up, a process that stops).
#pragma once

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

}  // namespace geodesic
