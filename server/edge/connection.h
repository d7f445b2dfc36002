// One accepted TCP connection, plain or TLS: what has arrived and was not used
// yet, and what is to be sent and was not taken yet. Nothing here waits, but for
// `send_all_waiting`; whoever drives a connection waits for the socket in between.
// It knows where a request's head ends, and nothing else of HTTP. Bytes after a
// request stay for the next one (pipelining).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "server/base/reply_file.h"
#include "server/base/unique_fd.h"
#include "server/edge/progress.h"
#include "server/edge/tls.h"

namespace geodesic::server {

// What other threads may know of a connection: whether the peer has hung up.
// Outlives it, and then says yes.
class PeerWatch {
 public:
  explicit PeerWatch(UniqueFd socket) : socket_(std::move(socket)) {}
  // The peer has closed, or half-closed, its end; or the connection is closed.
  [[nodiscard]] bool gone() const;
  // Ends all reading and writing at once; whoever waits for the socket wakes up.
  void cut() const;
  // Closes the socket.
  void close();

 private:
  mutable std::mutex mutex_;
  UniqueFd socket_;  // none once closed, so that no other file is mistaken for it
};

class HttpConnection {
 public:
  using Clock = std::chrono::steady_clock;
  using Milliseconds = std::chrono::milliseconds;

  // `tls` null: plain.
  explicit HttpConnection(UniqueFd socket, std::unique_ptr<TlsSession> tls = nullptr);
  ~HttpConnection();
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  [[nodiscard]] const std::shared_ptr<PeerWatch>& watch() const { return watch_; }
  [[nodiscard]] int socket() const { return socket_; }
  [[nodiscard]] std::string peer_address() const;  // without the port; "" if unknown

  // Up to `size` bytes from beneath TLS, which never sees them: before anything else.
  [[nodiscard]] Progress read_plain(char* out, std::size_t size, std::size_t& count);
  // To be done before a request is read; `done` at once if plain.
  [[nodiscard]] Progress handshake();

  // What has arrived and was not used.
  [[nodiscard]] std::string_view arrived() const { return std::string_view(buffer_).substr(used_); }
  void use(std::size_t bytes);
  // Adds up to `most` bytes of what the socket has; at least one when done.
  // `wants_read` only if nothing more can be had without waiting.
  [[nodiscard]] Progress receive(std::size_t most);

  enum class Head : std::uint8_t { complete, incomplete, target_too_long, too_long };
  // Looks for the empty line that ends a head in what has arrived. `size` is that
  // of the head, or of all that has arrived if it is not complete.
  [[nodiscard]] Head find_head(std::size_t max_target_bytes, std::size_t max_bytes,
                               std::size_t& size);

  // To be sent after what was queued before. The second form does not copy (nor
  // may anything be queued after it until it is sent).
  void queue(std::string_view bytes);
  void queue(std::shared_ptr<const std::string> bytes);
  // A file is read as it is sent; where it cannot be read to its end, `send` is `closed`.
  void queue(std::shared_ptr<const ReplyFile> file);
  [[nodiscard]] std::uint64_t unsent() const;
  // Sends what the socket takes; done: nothing is left.
  [[nodiscard]] Progress send();
  // The same, but waits for the socket: each byte sent buys `stall` more time, but
  // never beyond `deadline`. False on error or when time is over.
  [[nodiscard]] bool send_all_waiting(Milliseconds stall, Clock::time_point deadline);
  [[nodiscard]] std::uint64_t bytes_sent() const { return bytes_sent_; }

  // No more is going to be sent. Reading goes on.
  void say_goodbye();
  // Reads up to `most` bytes for nobody; `wants_read`: more may come.
  [[nodiscard]] Progress discard(std::size_t most);

 private:
  [[nodiscard]] Progress read(char* out, std::size_t size, std::size_t& count);
  [[nodiscard]] bool read_on();
  [[nodiscard]] Progress write(const char* data, std::size_t size, bool more, std::size_t& count);

  const int socket_;
  const std::shared_ptr<PeerWatch> watch_;
  const std::unique_ptr<TlsSession> tls_;

  std::string buffer_;
  std::size_t used_ = 0;      // bytes of the buffer already handed out
  std::size_t searched_ = 0;  // bytes after those that hold no end of a head

  std::string out_;
  std::size_t out_sent_ = 0;
  std::shared_ptr<const std::string> body_;  // follows `out_`
  std::size_t body_sent_ = 0;
  std::shared_ptr<const ReplyFile> file_;  // likewise
  std::uint64_t file_read_ = 0;
  std::string piece_;  // of the file, being sent
  std::size_t piece_sent_ = 0;
  std::uint64_t bytes_sent_ = 0;
};

}  // namespace geodesic::server
