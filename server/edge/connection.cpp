#include "server/edge/connection.h"

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>

namespace geodesic::server {

namespace {

constexpr std::size_t kReadChunk = 64u << 10;
// An idle connection keeps no more than this.
constexpr std::size_t kKeptBuffer = 4u << 10;
// A body up to this is copied behind its head, to leave in one piece.
constexpr std::size_t kCopiedBody = 16u << 10;

// A head starts with a method; TLS and other protocols do not.
bool may_start_method(char c) { return c > ' ' && c < 0x7f && c != ':' && c != '"' && c != '/'; }

bool would_block(int error) { return error == EAGAIN || error == EWOULDBLOCK; }

void give_back(std::string& buffer) {
  if (buffer.capacity() > kKeptBuffer) {
    std::string().swap(buffer);
  } else {
    buffer.clear();
  }
}

}  // namespace

bool PeerWatch::gone() const {
  const std::lock_guard lock(mutex_);
  if (!socket_) return true;
  pollfd query{socket_.get(), POLLRDHUP, 0};
  return ::poll(&query, 1, 0) > 0 && (query.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

void PeerWatch::cut() const {
  const std::lock_guard lock(mutex_);
  if (socket_) ::shutdown(socket_.get(), SHUT_RDWR);
}

void PeerWatch::close() {
  const std::lock_guard lock(mutex_);
  socket_.close();
}

HttpConnection::HttpConnection(UniqueFd socket, std::unique_ptr<TlsSession> tls)
    : socket_(socket.get()),
      watch_(std::make_shared<PeerWatch>(std::move(socket))),
      tls_(std::move(tls)) {
  ::fcntl(socket_, F_SETFL, ::fcntl(socket_, F_GETFL) | O_NONBLOCK);
}

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

Progress HttpConnection::handshake() { return tls_ ? tls_->handshake() : Progress::done; }

Progress HttpConnection::read_plain(char* out, std::size_t size, std::size_t& count) {
  while (true) {
    const ssize_t n = ::recv(socket_, out, size, 0);
    if (n > 0) {
      count = static_cast<std::size_t>(n);
      return Progress::done;
    }
    if (n < 0 && errno == EINTR) continue;
    return n < 0 && would_block(errno) ? Progress::wants_read : Progress::closed;
  }
}

Progress HttpConnection::read(char* out, std::size_t size, std::size_t& count) {
  return tls_ ? tls_->read(out, size, count) : read_plain(out, size, count);
}

// With `more`, what follows at once goes out in the same packet.
Progress HttpConnection::write(const char* data, std::size_t size, bool more, std::size_t& count) {
  if (tls_) return tls_->write(data, size, count);
  while (true) {
    const ssize_t n = ::send(socket_, data, size, MSG_NOSIGNAL | (more ? MSG_MORE : 0));
    if (n > 0) {
      count = static_cast<std::size_t>(n);
      return Progress::done;
    }
    if (n < 0 && errno == EINTR) continue;
    return n < 0 && would_block(errno) ? Progress::wants_write : Progress::closed;
  }
}

void HttpConnection::use(std::size_t bytes) {
  used_ += bytes;
  searched_ = 0;
  if (used_ == buffer_.size()) {
    used_ = 0;
    give_back(buffer_);
  }
}

Progress HttpConnection::receive(std::size_t most) {
  std::array<char, kReadChunk> chunk;
  std::size_t count = 0;
  const Progress progress = read(chunk.data(), std::min(most, chunk.size()), count);
  if (progress == Progress::done) {
    if (used_ != 0) {
      buffer_.erase(0, used_);
      used_ = 0;
    }
    buffer_.append(chunk.data(), count);
  }
  return progress;
}

auto HttpConnection::find_head(std::size_t max_target_bytes, std::size_t max_bytes,
                               std::size_t& size) -> Head {
  // Empty lines before a request are to be ignored (RFC 9112, 2.2).
  std::size_t skipped = 0;
  while (searched_ == 0 && arrived().substr(skipped, 2) == "\r\n") skipped += 2;
  if (skipped != 0) use(skipped);

  const std::string_view bytes = arrived();
  size = bytes.size();
  if (bytes.empty() || bytes == "\r") return Head::incomplete;
  if (!may_start_method(bytes.front())) return Head::complete;
  // The end may straddle what was searched before.
  const std::size_t end = bytes.find("\r\n\r\n", searched_ < 3 ? 0 : searched_ - 3);
  if (end != std::string_view::npos && end + 4 <= max_bytes) {
    size = end + 4;
    return Head::complete;
  }
  // Beside the target, a request line holds a method and a version.
  const std::size_t max_line = max_target_bytes + 64;
  const bool line_complete = bytes.substr(0, max_line).find("\r\n") != std::string_view::npos;
  if (!line_complete && bytes.size() > max_line) return Head::target_too_long;
  if (bytes.size() > max_bytes) return Head::too_long;
  searched_ = bytes.size();
  return Head::incomplete;
}

void HttpConnection::queue(std::string_view bytes) { out_ += bytes; }

void HttpConnection::queue(std::shared_ptr<const std::string> bytes) {
  if (bytes->size() <= kCopiedBody) {
    out_ += *bytes;
  } else {
    body_ = std::move(bytes);
    body_sent_ = 0;
  }
}

void HttpConnection::queue(std::shared_ptr<const ReplyFile> file) {
  file_ = std::move(file);
  file_read_ = 0;
}

// The next piece of the file; false where it cannot be read.
bool HttpConnection::read_on() {
  piece_.resize(std::min<std::uint64_t>(kReadChunk, file_->size() - file_read_));
  piece_.resize(file_->read(file_read_, piece_.data(), piece_.size()));
  piece_sent_ = 0;
  file_read_ += piece_.size();
  return !piece_.empty();
}

std::uint64_t HttpConnection::unsent() const {
  return out_.size() - out_sent_ + (body_ ? body_->size() - body_sent_ : 0) +
         (file_ ? file_->size() - file_read_ : 0) + piece_.size() - piece_sent_;
}

Progress HttpConnection::send() {
  while (true) {
    std::size_t count = 0;
    Progress progress = Progress::done;
    if (out_sent_ < out_.size()) {
      progress = write(out_.data() + out_sent_, out_.size() - out_sent_,
                       (body_ && !body_->empty()) || file_, count);
      out_sent_ += count;
    } else if (body_ && body_sent_ < body_->size()) {
      progress = write(body_->data() + body_sent_, body_->size() - body_sent_, false, count);
      body_sent_ += count;
    } else if (piece_sent_ < piece_.size()) {
      progress = write(piece_.data() + piece_sent_, piece_.size() - piece_sent_, false, count);
      piece_sent_ += count;
    } else if (file_ && file_read_ < file_->size()) {
      if (!read_on()) return Progress::closed;
    } else {
      break;
    }
    bytes_sent_ += count;
    if (progress != Progress::done) return progress;
  }
  give_back(out_);
  out_sent_ = 0;
  body_.reset();
  file_.reset();
  std::string().swap(piece_);
  piece_sent_ = 0;
  return Progress::done;
}

bool HttpConnection::send_all_waiting(Milliseconds stall, Clock::time_point deadline) {
  Clock::time_point stalled = Clock::now() + stall;
  while (true) {
    const std::uint64_t before = bytes_sent_;
    const Progress progress = send();
    if (progress == Progress::done) return true;
    if (progress == Progress::closed) return false;
    const Clock::time_point now = Clock::now();
    if (bytes_sent_ != before) stalled = now + stall;
    const auto left = std::chrono::ceil<Milliseconds>(std::min(stalled, deadline) - now);
    if (left.count() <= 0) return false;
    pollfd query{socket_, static_cast<short>(progress == Progress::wants_write ? POLLOUT : POLLIN),
                 0};
    ::poll(&query, 1, static_cast<int>(std::min<Milliseconds::rep>(left.count(), INT_MAX)));
  }
}

void HttpConnection::say_goodbye() {
  if (tls_) tls_->say_goodbye();
  ::shutdown(socket_, SHUT_WR);
}

Progress HttpConnection::discard(std::size_t most) {
  use(arrived().size());
  std::array<char, kReadChunk> nobody;
  while (most > 0) {
    // Beneath TLS: what it says is of no interest any more.
    const ssize_t n = ::recv(socket_, nobody.data(), std::min(most, nobody.size()), 0);
    if (n == 0) return Progress::closed;
    if (n < 0 && errno != EINTR) {
      return would_block(errno) ? Progress::wants_read : Progress::closed;
    }
    if (n > 0) most -= static_cast<std::size_t>(n);
  }
  return Progress::wants_read;
}

}  // namespace geodesic::server
