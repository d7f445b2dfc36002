// Asks one question at a steady pace and tells how long the answers took.
//
//     paced_client PORT TARGET RATE SECONDS [CONNECTIONS]
//
// RATE requests a second in all, over 16 connections; 0: as fast as they are
// answered. A request's time runs from when it was due, not from when it could be
// sent, so that a server which stalls cannot hide behind a waiting client. One thread
// does it all: a thread a connection would vie with the server's for the cores, and
// what would be measured then is the scheduler. Prints one line of JSON: requests,
// failed, seconds, rate, p50_ms, p99_ms, max_ms.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <string>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

class Connection {
 public:
  explicit Connection(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int on = 1;
    ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    open_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  ~Connection() { ::close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  [[nodiscard]] int socket() const { return socket_; }
  [[nodiscard]] bool open() const { return open_; }

  // A request is small enough for the socket's buffer.
  void send(const std::string& request, Clock::time_point due) {
    due_ = due;
    head_.clear();
    left_ = kUnknown;
    open_ = open_ && ::send(socket_, request.data(), request.size(), MSG_NOSIGNAL) ==
                         static_cast<ssize_t>(request.size());
  }

  // Takes what has arrived; whether the answer, a 200, is whole now.
  bool receive() {
    const ssize_t count = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    if (count < 0 && errno == EAGAIN) return false;
    open_ = count > 0;
    if (!open_) return false;
    auto fresh = static_cast<std::size_t>(count);
    if (left_ == kUnknown) {
      head_.append(buffer_.data(), fresh);
      const std::size_t end = head_.find("\r\n\r\n");
      if (end == std::string::npos) return false;
      const std::size_t at = head_.find("Content-Length: ");
      open_ = at < end && head_.compare(9, 3, "200") == 0;
      if (!open_) return false;
      left_ = std::strtoull(head_.c_str() + at + 16, nullptr, 10);
      fresh = head_.size() - (end + 4);
    }
    left_ -= std::min(left_, fresh);
    return left_ == 0;
  }

  [[nodiscard]] double milliseconds() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - due_).count();
  }

 private:
  static constexpr std::size_t kUnknown = ~std::size_t{0};
  int socket_;
  bool open_ = false;
  Clock::time_point due_;
  std::string head_;
  std::size_t left_ = kUnknown;  // of the body
  std::vector<char> buffer_ = std::vector<char>(1 << 18);
};

void watch(int poll, int file, std::uint64_t number) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.u64 = number;
  ::epoll_ctl(poll, EPOLL_CTL_ADD, file, &event);
}

double at(const std::vector<double>& sorted, double quantile) {
  if (sorted.empty()) return 0;
  return sorted[static_cast<std::size_t>(quantile * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::fprintf(stderr, "usage: paced_client PORT TARGET RATE SECONDS [CONNECTIONS]\n");
    return 2;
  }
  const auto port = static_cast<std::uint16_t>(std::atoi(argv[1]));
  const std::string request = "GET " + std::string(argv[2]) + " HTTP/1.1\r\nHost: x\r\n\r\n";
  const double rate = std::atof(argv[3]);
  const Seconds duration(std::atof(argv[4]));
  const std::size_t count = argc > 5 ? std::strtoul(argv[5], nullptr, 10) : 16;

  const int poll = ::epoll_create1(0);
  const int timer = ::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK);
  std::deque<Connection> connections;
  std::vector<std::size_t> idle;
  for (std::size_t c = 0; c < count; ++c) {
    watch(poll, connections.emplace_back(port).socket(), c);
    idle.push_back(c);
  }
  watch(poll, timer, count);

  std::vector<double> times;
  std::size_t failures = 0;
  std::size_t asked = 0;
  std::size_t waiting = 0;  // sent, not answered
  const Clock::time_point begin = Clock::now();
  const Clock::time_point end = begin + std::chrono::duration_cast<Clock::duration>(duration);
  const auto due = [&] {  // when the next request is
    return rate > 0 ? begin + std::chrono::duration_cast<Clock::duration>(
                                  Seconds(static_cast<double>(asked) / rate))
                    : Clock::now();
  };
  while (true) {
    Clock::time_point next = due();
    while (!idle.empty() && next <= Clock::now() && next < end) {
      Connection& connection = connections[idle.back()];
      idle.pop_back();
      connection.send(request, next);
      ++asked;
      if (connection.open()) {
        ++waiting;
      } else {
        ++failures;
      }
      next = due();
    }
    if (waiting == 0 && (next >= end || idle.empty())) break;
    if (!idle.empty() && next < end) {
      const auto wait =
          std::max<std::chrono::nanoseconds>(next - Clock::now(), std::chrono::nanoseconds(1));
      itimerspec when{};
      when.it_value.tv_sec = std::chrono::duration_cast<std::chrono::seconds>(wait).count();
      when.it_value.tv_nsec = wait.count() % 1'000'000'000;
      ::timerfd_settime(timer, 0, &when, nullptr);
    }
    std::array<epoll_event, 64> events{};
    const int ready = ::epoll_wait(poll, events.data(), static_cast<int>(events.size()), -1);
    for (int e = 0; e < ready; ++e) {
      const std::size_t c = events[static_cast<std::size_t>(e)].data.u64;
      if (c == count) {
        std::uint64_t expirations = 0;
        (void)!::read(timer, &expirations, sizeof expirations);
        continue;
      }
      if (connections[c].receive()) {
        times.push_back(connections[c].milliseconds());
        idle.push_back(c);
        --waiting;
      } else if (!connections[c].open()) {
        ::epoll_ctl(poll, EPOLL_CTL_DEL, connections[c].socket(), nullptr);
        ++failures;
        --waiting;
      }
    }
  }
  const double seconds = Seconds(Clock::now() - begin).count();
  ::close(timer);
  ::close(poll);

  std::sort(times.begin(), times.end());
  std::printf(
      "{\"requests\": %zu, \"failed\": %zu, \"seconds\": %.3f, \"rate\": %.1f, \"p50_ms\": %.3f, "
      "\"p99_ms\": %.3f, \"max_ms\": %.3f}\n",
      times.size(), failures, seconds, static_cast<double>(times.size()) / seconds, at(times, 0.5),
      at(times, 0.99), at(times, 1.0));
  return failures == 0 ? 0 : 1;
}
