#include "server/http_connection.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstring>

namespace geodesic::server {

namespace {

constexpr std::size_t read_chunk = 16u << 10;

// Milliseconds for poll, rounded up so that it does not spin at the end.
int poll_timeout(HttpConnection::Clock::time_point deadline) {
  if (deadline == HttpConnection::Clock::time_point::max()) return -1;
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(deadline - HttpConnection::Clock::now());
  return static_cast<int>(std::clamp<std::chrono::milliseconds::rep>(left.count(), 0, INT_MAX));
}

// A head starts with a method; TLS and other protocols do not.
bool may_start_method(char c) { return c > ' ' && c < 0x7f && c != ':' && c != '"' && c != '/'; }

}  // namespace

bool PeerWatch::gone() const {
  const std::lock_guard lock(mutex_);
  if (socket_ < 0) return true;
  pollfd query{socket_, POLLRDHUP, 0};
  return ::poll(&query, 1, 0) > 0 && (query.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

void PeerWatch::cut() const {
  const std::lock_guard lock(mutex_);
  if (socket_ >= 0) ::shutdown(socket_, SHUT_RDWR);
}

void PeerWatch::close() {
  const std::lock_guard lock(mutex_);
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

HttpConnection::HttpConnection(int socket)
    : socket_(socket), watch_(std::make_shared<PeerWatch>(socket)) {}

HttpConnection::~HttpConnection() { watch_->close(); }

std::string HttpConnection::peer_address() const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  std::array<char, NI_MAXHOST> name{};
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  if (::getpeername(socket_, generic, &size) != 0) return {};
  if (::getnameinfo(generic, size, name.data(), name.size(), nullptr, 0, NI_NUMERICHOST) != 0) {
    return {};
  }
  return name.data();
}

bool HttpConnection::wait(short events, Clock::time_point deadline) const {
  while (true) {
    pollfd query{socket_, events, 0};
    const int ready = ::poll(&query, 1, poll_timeout(deadline));
    if (ready > 0) return true;  // POLLERR and POLLHUP too: the next call tells
    if (ready < 0 && errno != EINTR) return false;
    if (ready == 0 && Clock::now() >= deadline) return false;
  }
}

bool HttpConnection::wait_for_request(Milliseconds timeout, const std::function<bool()>& give_up) {
  if (used_ < buffer_.size()) return true;
  const Clock::time_point deadline = Clock::now() + timeout;
  constexpr Milliseconds step{50};
  while (true) {
    const Clock::time_point now = Clock::now();
    if (wait(POLLIN, std::min(deadline, now + step))) return true;
    if (give_up() || Clock::now() >= deadline) return false;
  }
}

bool HttpConnection::fill(Clock::time_point deadline) {
  if (used_ == buffer_.size()) {
    buffer_.clear();
    used_ = 0;
  }
  std::array<char, read_chunk> chunk;
  while (true) {
    // Time is looked at even when bytes are there: a trickle must not outlive the deadline.
    if (!wait(POLLIN, deadline) || Clock::now() > deadline) {
      timed_out_ = true;
      return false;
    }
    const ssize_t n = ::recv(socket_, chunk.data(), chunk.size(), MSG_DONTWAIT);
    if (n > 0) {
      buffer_.append(chunk.data(), static_cast<std::size_t>(n));
      return true;
    }
    if (n < 0 && (errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK)) continue;
    closed_ = true;
    return false;
  }
}

auto HttpConnection::read_head(std::size_t max_target_bytes, std::size_t max_bytes,
                               Clock::time_point deadline, std::string& head) -> Head {
  // Beside the target, a request line holds a method and a version.
  const std::size_t max_line = max_target_bytes + 64;
  std::size_t searched = 0;
  const auto give = [&](Head outcome, std::size_t size) {
    head.assign(buffer_, used_, size);
    used_ += head.size();
    return outcome;
  };
  while (true) {
    // Empty lines before a request are to be ignored (RFC 9112, 2.2).
    while (searched == 0 && buffer_.compare(used_, 2, "\r\n") == 0) used_ += 2;
    const std::string_view arrived = std::string_view(buffer_).substr(used_);
    if (!arrived.empty() && arrived != "\r") {
      if (!may_start_method(arrived.front())) return give(Head::complete, arrived.size());
      // The end may straddle what was searched before.
      const std::size_t end = arrived.find("\r\n\r\n", searched < 3 ? 0 : searched - 3);
      if (end != std::string_view::npos && end + 4 <= max_bytes) {
        return give(Head::complete, end + 4);
      }
      const bool line_complete = arrived.substr(0, max_line).find("\r\n") != std::string_view::npos;
      if (!line_complete && arrived.size() > max_line) {
        return give(Head::target_too_long, arrived.size());
      }
      if (arrived.size() > max_bytes) return give(Head::too_long, arrived.size());
      searched = arrived.size();
    }
    if (!fill(deadline)) {
      return give(timed_out_ ? Head::timed_out : Head::closed, std::string::npos);
    }
  }
}

ssize_t HttpConnection::read(char* out, std::size_t size) {
  if (refused_ || size == 0) return -1;
  if (used_ == buffer_.size()) {
    // Large reads bypass the buffer.
    while (size >= read_chunk) {
      if (!wait(POLLIN, read_deadline_) || Clock::now() > read_deadline_) {
        timed_out_ = true;
        return -1;
      }
      const ssize_t n = ::recv(socket_, out, size, MSG_DONTWAIT);
      if (n < 0 && (errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK)) continue;
      if (n <= 0) closed_ = true;
      return n;
    }
    if (!fill(read_deadline_)) return closed_ ? 0 : -1;
  }
  const std::size_t n = std::min(size, buffer_.size() - used_);
  std::memcpy(out, buffer_.data() + used_, n);
  used_ += n;
  return static_cast<ssize_t>(n);
}

void HttpConnection::set_write_limits(Milliseconds stall, Clock::time_point deadline) {
  stall_ = stall;
  write_deadline_ = deadline;
}

ssize_t HttpConnection::write(const char* data, std::size_t size) {
  while (true) {
    if (!wait(POLLOUT, std::min(write_deadline_, Clock::now() + stall_))) return -1;
    const ssize_t n = ::send(socket_, data, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n > 0) {
      bytes_sent_ += static_cast<std::uint64_t>(n);
      return n;
    }
    if (n < 0 && (errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK)) continue;
    return -1;
  }
}

void HttpConnection::linger(bool more_may_come) {
  ::shutdown(socket_, SHUT_WR);
  pollfd query{socket_, POLLIN, 0};
  if (!more_may_come && ::poll(&query, 1, 0) <= 0) return;
  const Clock::time_point deadline = Clock::now() + std::chrono::seconds(1);
  std::array<char, read_chunk> discarded;
  while (wait(POLLIN, deadline) && Clock::now() < deadline) {
    const ssize_t n = ::recv(socket_, discarded.data(), discarded.size(), MSG_DONTWAIT);
    if (n == 0) return;
    if (n < 0 && errno != EINTR && errno != EAGAIN && errno != EWOULDBLOCK) return;
  }
}

}  // namespace geodesic::server
