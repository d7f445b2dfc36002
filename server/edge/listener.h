// Accepts the connections of a listening socket, on one thread. It waits out errors that may pass,
// such as a lack of file descriptors or memory. One that cannot pass ends it with a reason.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

#include "server/base/unique_fd.h"

namespace geodesic::server {

class HttpListener {
 public:
  // As accept4 without addresses: a connection's socket, or -1 and errno.
  using Accept = std::function<int(int socket)>;

  explicit HttpListener(Accept accept) : accept_(std::move(accept)) {}

  // Hands each connection to `adopt`, until `stop` or until the socket fails for good.
  // Returns why it ended; empty: it was stopped. To be called once.
  [[nodiscard]] std::string run(int socket, const std::function<void(UniqueFd)>& adopt);
  // Any thread. The listening socket must be shut down as well: `run` may wait for it.
  void stop();

  // Failed attempts since the start, including those that lost only one connection.
  [[nodiscard]] std::uint64_t failures() const { return failures_; }
  // False while connections wait that cannot be taken, and once it has ended by itself.
  [[nodiscard]] bool is_accepting() const { return is_accepting_; }

  // What a failed accept means.
  enum class Failure : std::uint8_t {
    interrupted,      // nothing
    connection_lost,  // of one connection only: the next may be accepted
    shortage,         // of files or memory, or not known: may pass
    socket_dead,      // no connection will ever come
  };
  [[nodiscard]] static Failure meaning_of(int error);

 private:
  void tell(int error);
  void pause(int socket);

  const Accept accept_;
  std::atomic<std::uint64_t> failures_{0};
  std::atomic<bool> is_accepting_{true};
  std::chrono::milliseconds pause_{0};
  std::chrono::steady_clock::time_point told_{};  // when the log was told last

  std::mutex mutex_;
  std::condition_variable stop_signal_;
  std::atomic<bool> is_stopping_{false};  // set under the mutex
};

}  // namespace geodesic::server
