// A TCP client for tests of the HTTP edge: sends exactly the bytes it is given
// and reads replies with a parser of its own, so that the server's is not
// tested against itself.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace geodesic::server::test {

struct RawReply {
  int status = 0;
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;
};

class RawClient {
 public:
  // From 127.0.0.`from`: a client of its own.
  explicit RawClient(int port, unsigned from = 1) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK - 1 + from);
    if (from != 1 && ::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      ::close(socket_);
      throw std::runtime_error("cannot bind");
    }
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      ::close(socket_);
      throw std::runtime_error("cannot connect");
    }
  }
  ~RawClient() { ::close(socket_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  // False once the server no longer takes bytes.
  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }

  // The next reply; status 0 if the connection ended or nothing came in time.
  RawReply receive(bool is_head = false, std::chrono::milliseconds patience = default_patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    RawReply reply;
    std::size_t end;
    while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
      if (!fill(deadline)) return reply;
    }
    const std::string head = take(end + 4);
    reply.status = std::atoi(head.c_str() + 9);
    for (std::size_t at = head.find("\r\n") + 2; at + 2 < head.size();) {
      const std::size_t stop = head.find("\r\n", at);
      const std::size_t colon = head.find(": ", at);
      std::string name = head.substr(at, colon - at);
      for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      reply.headers[name] = head.substr(colon + 2, stop - colon - 2);
      at = stop + 2;
    }
    if (reply.status == 100) return receive(is_head, patience);
    if (is_head || reply.status == 204 || reply.status == 304) return reply;
    if (const auto length = reply.headers.find("content-length"); length != reply.headers.end()) {
      const std::size_t size = std::stoull(length->second);
      while (buffer_.size() < size) {
        if (!fill(deadline)) return RawReply{};
      }
      reply.body = take(size);
    } else if (reply.headers["transfer-encoding"] == "chunked") {
      while (true) {
        while ((end = buffer_.find("\r\n")) == std::string::npos) {
          if (!fill(deadline)) return RawReply{};
        }
        const std::size_t size = std::strtoull(take(end + 2).c_str(), nullptr, 16);
        while (buffer_.size() < size + 2) {
          if (!fill(deadline)) return RawReply{};
        }
        reply.body += take(size + 2).substr(0, size);
        if (size == 0) break;
      }
    } else {
      while (fill(deadline)) {
      }
      reply.body = take(buffer_.size());
    }
    return reply;
  }

  // Every byte until the server closes the connection or falls silent.
  std::string receive_all(std::chrono::milliseconds patience = default_patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (fill(deadline)) {
    }
    return std::exchange(buffer_, {});
  }

  // Whether the server closes the connection, with nothing more to read.
  bool ends(std::chrono::milliseconds patience = default_patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    return buffer_.empty() && !fill(deadline) && ended_;
  }

  void half_close() { ::shutdown(socket_, SHUT_WR); }
  int socket() const { return socket_; }

 private:
  static constexpr std::chrono::milliseconds default_patience{30000};

  std::string take(std::size_t size) {
    std::string bytes = buffer_.substr(0, size);
    buffer_.erase(0, size);
    return bytes;
  }

  bool fill(std::chrono::steady_clock::time_point deadline) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    pollfd query{socket_, POLLIN, 0};
    if (left.count() <= 0 || ::poll(&query, 1, static_cast<int>(left.count())) <= 0) return false;
    char bytes[65536];
    const ssize_t n = ::recv(socket_, bytes, sizeof bytes, 0);
    ended_ = n <= 0;
    if (ended_) return false;
    buffer_.append(bytes, static_cast<std::size_t>(n));
    return true;
  }

  int socket_;
  std::string buffer_;
  bool ended_ = false;
};

}  // namespace geodesic::server::test
