// One accepted TCP connection: buffered reading and writing against deadlines.
// It knows where a request's head ends, and nothing else of HTTP. Deadlines are
// absolute, so a peer that sends a byte a second gains nothing by it. Bytes
// after a request stay in the buffer for the next one (pipelining).
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace geodesic::server {

// What other threads may know of a connection: whether the peer has hung up.
// Outlives it, and then says yes.
class PeerWatch {
 public:
  explicit PeerWatch(int socket) : socket_(socket) {}
  // The peer has closed, or half-closed, its end; or the connection is closed.
  [[nodiscard]] bool gone() const;
  // Ends all reading and writing at once; the connection's thread notices.
  void cut() const;
  // Closes the socket.
  void close();

 private:
  mutable std::mutex mutex_;
  int socket_;  // -1 once closed, so that no other file is mistaken for it
};

class HttpConnection {
 public:
  using Clock = std::chrono::steady_clock;
  using Milliseconds = std::chrono::milliseconds;

  explicit HttpConnection(int socket);  // takes the socket over
  ~HttpConnection();
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  [[nodiscard]] const std::shared_ptr<PeerWatch>& watch() const { return watch_; }
  [[nodiscard]] int socket() const { return socket_; }
  [[nodiscard]] std::string peer_address() const;  // without the port; "" if unknown

  // Waits until there is a byte to read; false when `timeout` is over, the peer
  // has closed or `give_up` says so (asked every 50 ms).
  [[nodiscard]] bool wait_for_request(Milliseconds timeout, const std::function<bool()>& give_up);

  enum class Head { complete, target_too_long, too_long, timed_out, closed };
  // Reads up to and including the empty line that ends a head; the bytes (of
  // whatever came, if it is not complete) are in `head`.
  [[nodiscard]] Head read_head(std::size_t max_target_bytes, std::size_t max_bytes,
                               Clock::time_point deadline, std::string& head);

  // Applies to `read` from here on.
  void set_read_deadline(Clock::time_point deadline) { read_deadline_ = deadline; }
  // Up to `size` bytes; 0: the peer has closed; -1: the deadline is over (then
  // `timed_out()`), an error, or reading was refused.
  [[nodiscard]] ssize_t read(char* out, std::size_t size);
  [[nodiscard]] bool timed_out() const { return timed_out_; }
  [[nodiscard]] bool closed() const { return closed_; }
  // Lets every further `read` fail: what comes is no longer of interest.
  void refuse_reads() { refused_ = true; }

  // Applies to `write` from here on: each byte sent buys `stall` more time, but
  // never beyond `deadline`.
  void set_write_limits(Milliseconds stall, Clock::time_point deadline);
  // Sends some of the bytes, at least one; -1 on error or when time is over.
  [[nodiscard]] ssize_t write(const char* data, std::size_t size);
  [[nodiscard]] std::uint64_t bytes_sent() const { return bytes_sent_; }

  // Says goodbye so that the peer can still read the reply: closing with unread
  // bytes would reset the connection and may destroy what is on its way. Reads
  // and discards for a second at the most, and only if something is unread.
  void linger(bool more_may_come);

 private:
  // Waits for `events` (of poll); false when the deadline is over or on error.
  [[nodiscard]] bool wait(short events, Clock::time_point deadline) const;
  // Appends what has arrived to the buffer; false: closed, error or deadline.
  [[nodiscard]] bool fill(Clock::time_point deadline);

  const int socket_;
  const std::shared_ptr<PeerWatch> watch_;
  std::string buffer_;
  std::size_t used_ = 0;  // bytes of the buffer already handed out
  Clock::time_point read_deadline_ = Clock::time_point::max();
  Clock::time_point write_deadline_ = Clock::time_point::max();
  Milliseconds stall_{10000};
  bool timed_out_ = false;
  bool closed_ = false;
  bool refused_ = false;
  std::uint64_t bytes_sent_ = 0;
};

}  // namespace geodesic::server
