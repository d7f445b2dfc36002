#include "server/edge/listener.h"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <utility>

namespace geodesic::server {

namespace {

constexpr std::chrono::milliseconds kFirstPause{1};
constexpr std::chrono::milliseconds kLongestPause{500};
constexpr std::chrono::seconds kTellEvery{10};

}  // namespace

auto HttpListener::meaning_of(int error) -> Failure {
  switch (error) {
    case EINTR:
      return Failure::interrupted;
    case ECONNABORTED:
    case EPROTO:
    // Linux reports errors that the new connection already has; see accept(2).
    case ENETDOWN:
    case ENOPROTOOPT:
    case EHOSTDOWN:
    case ENONET:
    case EHOSTUNREACH:
    case ENETUNREACH:
    case ETIMEDOUT:
    case EPERM:  // a firewall's doing
      return Failure::connection_lost;
    case EBADF:
    case EINVAL:
    case ENOTSOCK:
    case EOPNOTSUPP:
    case EFAULT:
      return Failure::socket_dead;
    default:  // EMFILE, ENFILE, ENOMEM, ENOBUFS, and what nobody foresaw
      return Failure::shortage;
  }
}

std::string HttpListener::run(int socket, const std::function<void(UniqueFd)>& adopt) {
  while (!is_stopping_) {
    errno = 0;
    UniqueFd connection(accept_(socket));
    const int error = errno;
    if (connection) {
      if (!is_accepting_.exchange(true)) spdlog::info("connections are accepted again");
      pause_ = std::chrono::milliseconds(0);
      try {
        adopt(std::move(connection));
      } catch (const std::exception& thrown) {  // out of memory: its socket is closed
        spdlog::error("a connection could not be taken: {}", thrown.what());
      }
      continue;
    }
    const Failure failure = meaning_of(error);
    if (is_stopping_ || failure == Failure::interrupted) continue;
    ++failures_;
    if (failure == Failure::socket_dead) {
      is_accepting_ = false;
      return std::strerror(error);
    }
    tell(error);
    if (failure == Failure::shortage) is_accepting_ = false;
    pause(socket);
  }
  return {};
}

void HttpListener::tell(int error) {
  const auto now = std::chrono::steady_clock::now();
  if (failures_ != 1 && now - told_ < kTellEvery) return;
  told_ = now;
  spdlog::error("a connection cannot be accepted: {} ({} failures so far)", std::strerror(error),
                failures_.load());
}

// Each pause is twice as long as the one before, up to a bound. A lost connection alone would need
// no pause, but the next attempt may fail too.
void HttpListener::pause(int socket) {
  pause_ = std::clamp(2 * pause_, kFirstPause, kLongestPause);
  std::unique_lock lock(mutex_);
  stop_signal_.wait_for(lock, pause_, [this] { return is_stopping_.load(); });
  // If no connection waits, none is kept waiting: that counts as accepting.
  pollfd query{socket, POLLIN, 0};
  if (::poll(&query, 1, 0) == 0) is_accepting_ = true;
}

void HttpListener::stop() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  stop_signal_.notify_all();
}

}  // namespace geodesic::server
