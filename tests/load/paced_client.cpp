// Asks one question at a steady pace and tells how long the answers took.
//
//     paced_client PORT TARGET RATE SECONDS [CONNECTIONS]
//
// RATE requests a second in all, over 16 connections; 0: as fast as they are
// answered. A request's time runs from when it was due, not from when it could be
// sent, so that a server which stalls cannot hide behind a waiting client. Prints
// one line of JSON: requests, failed, seconds, rate, p50_ms, p99_ms, max_ms.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
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

  // Whether a 200 came back, with all of its body.
  bool ask(const std::string& request) {
    if (!open_) return false;
    open_ = ::send(socket_, request.data(), request.size(), MSG_NOSIGNAL) ==
            static_cast<ssize_t>(request.size());
    std::string head;
    std::size_t end = std::string::npos;
    while (open_ && (end = head.find("\r\n\r\n")) == std::string::npos) {
      const std::size_t count = read();
      head.append(buffer_.data(), count);
    }
    if (!open_) return false;
    const std::size_t at = head.find("Content-Length: ");
    if (at == std::string::npos || at > end) return open_ = false;
    const std::size_t size = std::strtoull(head.c_str() + at + 16, nullptr, 10);
    std::size_t have = head.size() - (end + 4);
    while (open_ && have < size) have += read();
    return open_ && head.compare(9, 3, "200") == 0;
  }

 private:
  std::size_t read() {
    const ssize_t count = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
    open_ = count > 0;
    return open_ ? static_cast<std::size_t>(count) : 0;
  }
  int socket_;
  bool open_ = false;
  std::vector<char> buffer_ = std::vector<char>(1 << 18);
};

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
  const std::size_t connections = argc > 5 ? std::strtoul(argv[5], nullptr, 10) : 16;

  std::vector<std::vector<double>> times(connections);
  std::vector<std::size_t> failed(connections, 0);
  const Clock::time_point begin = Clock::now();
  std::vector<std::thread> threads;
  for (std::size_t c = 0; c < connections; ++c) {
    threads.emplace_back([&, c] {
      Connection connection(port);
      const Seconds step(rate > 0 ? static_cast<double>(connections) / rate : 0);
      // Evenly spread over the connections.
      Seconds due = step * (static_cast<double>(c) / static_cast<double>(connections));
      while (true) {
        Clock::time_point from = Clock::now();
        if (rate > 0) {
          from = begin + std::chrono::duration_cast<Clock::duration>(due);
          due += step;
          std::this_thread::sleep_until(from);
        }
        if (from - begin >= duration) break;
        if (!connection.ask(request)) {
          ++failed[c];
          break;
        }
        times[c].push_back(std::chrono::duration<double, std::milli>(Clock::now() - from).count());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  const double seconds = Seconds(Clock::now() - begin).count();

  std::vector<double> all;
  std::size_t failures = 0;
  for (std::size_t c = 0; c < connections; ++c) {
    all.insert(all.end(), times[c].begin(), times[c].end());
    failures += failed[c];
  }
  std::sort(all.begin(), all.end());
  std::printf(
      "{\"requests\": %zu, \"failed\": %zu, \"seconds\": %.3f, \"rate\": %.1f, \"p50_ms\": %.3f, "
      "\"p99_ms\": %.3f, \"max_ms\": %.3f}\n",
      all.size(), failures, seconds, static_cast<double>(all.size()) / seconds, at(all, 0.5),
      at(all, 0.99), at(all, 1.0));
  return failures == 0 ? 0 : 1;
}
