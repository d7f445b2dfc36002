#include "server/edge/server.h"

// Connections wait here, not in the kernel, for the accepting thread.
#define CPPHTTPLIB_LISTEN_BACKLOG 1024
#include <httplib.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "server/base/reply_file.h"
#include "server/edge/connection.h"
#include "server/edge/conversation.h"
#include "server/edge/exchange.h"
#include "server/edge/listener.h"
#include "server/edge/reply_head.h"
#include "server/edge/workers.h"
#include "server/http/problem.h"
#include "server/http/request_log.h"

// How cpp-httplib is used. It binds and listens, and it writes replies. What it would make of
// a failed accept, closing the socket for good, is not wanted: edge/listener.h accepts.
// It does not read what clients send: edge/conversation.h does, strictly, with raw
// values and without holding a thread; once a request is complete, cpp-httplib gets
// a head of our own in its place, which says nothing. So none of its conveniences
// (form parsing, ranges, WebSockets, decoded header values, replies of its own) can
// be reached from outside, and every request, whatever its method and path,
// arrives at one place below.

namespace geodesic::server {

namespace {

using Clock = HttpConnection::Clock;

// A request is answered on one thread, so cpp-httplib's callbacks find its exchange
// in a variable of that thread.
thread_local Exchange* current_exchange = nullptr;

// When so many bytes that are streamed must be sent.
Clock::time_point sent_by(const HttpOptions& options, std::uint64_t bytes) {
  if (options.min_send_rate == 0) return Clock::time_point::max();
  return Clock::now() + options.write_timeout + std::chrono::seconds(bytes / options.min_send_rate);
}

// A streamed chunk is handed on in pieces of so many bytes: each is copied on its way.
constexpr std::size_t kChunkPiece = std::size_t{64} << 10;

// What cpp-httplib reads, a request that says nothing, and where it writes: the
// connection's queue or, if the reply is streamed, the socket.
class ReplyStream final : public httplib::Stream {
 public:
  ReplyStream(Exchange& exchange, const HttpOptions& options)
      : exchange_(exchange), options_(options) {}

  bool is_readable() const override { return used_ < kHead.size(); }
  bool wait_readable() const override { return true; }
  bool wait_writable() const override { return true; }  // `write` waits
  bool is_peer_alive() const override { return true; }  // `write` finds out

  ssize_t read(char* out, std::size_t size) override {
    const std::size_t count = kHead.copy(out, size, used_);
    used_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* data, std::size_t size) override {
    HttpConnection& connection = exchange_.connection;
    std::string_view bytes(data, size);
    if (!std::exchange(begun_, true)) {
      const std::size_t end_of_status = std::string_view("HTTP/1.1 499").size();
      const std::string_view rest = bytes.substr(std::min(end_of_status, size));
      if (rest.starts_with(kWordless) && reason_of(exchange_.status) != kWordless) {
        connection.queue(bytes.substr(0, end_of_status));
        connection.queue(reason_of(exchange_.status));
        bytes = rest.substr(kWordless.size());
      }
    }
    connection.queue(bytes);
    if (exchange_.streams) {
      const Clock::time_point deadline = sent_by(options_, connection.unsent());
      if (!connection.send_all_waiting(options_.write_timeout, deadline)) return -1;
    }
    return static_cast<ssize_t>(size);
  }
  using httplib::Stream::write;

  // The addresses are asked of the socket before there is a stream.
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return exchange_.connection.socket(); }
  time_t duration() const override { return 0; }

 private:
  static constexpr std::string_view kHead = "GET / HTTP/1.1\r\n\r\n";
  Exchange& exchange_;
  const HttpOptions& options_;
  std::size_t used_ = 0;
  bool begun_ = false;  // the reply has
};

// Replies up to this are sent however many wait: that all is well, or what is not.
constexpr std::uint64_t kSmallReply = 16u << 10;

int accept_one(int socket) { return ::accept4(socket, nullptr, nullptr, SOCK_CLOEXEC); }

// Counts for as long as it lives.
class Counted {
 public:
  explicit Counted(std::atomic<std::uint64_t>& counter) : counter_(counter) { ++counter_; }
  ~Counted() { --counter_; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

 private:
  std::atomic<std::uint64_t>& counter_;
};

}  // namespace

class HttpServer::Impl final : public httplib::Server {
 public:
  Impl(HttpOptions options, HttpHandler handler)
      : handler_(std::move(handler)),
        edge_{std::move(options), [this](Exchange& exchange) { answer(exchange); }},
        workers_(edge_),
        acceptor_(edge_.options.accept ? edge_.options.accept : accept_one) {
    // Only SO_REUSEADDR: with SO_REUSEPORT a second server would start silently.
    set_socket_options([](socket_t socket) {
      const int on = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    });
    set_error_logger([this](const httplib::Error& error, const httplib::Request*) {
      // Called right after the system call that failed.
      if (error == httplib::Error::BindIPAddress || error == httplib::Error::Listen) {
        bind_errno_ = errno;
      }
    });
    Get("/", [this](const httplib::Request&, httplib::Response& response) {
      Exchange& exchange = *current_exchange;
      hand_over(handle(exchange), exchange, response);
    });
    set_post_routing_handler([this](const httplib::Request&, httplib::Response& response) {
      finish_headers(*current_exchange, response);
    });
    // Out of memory while a reply is being put together; nothing else throws there.
    set_exception_handler(
        [this](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
          response.headers.clear();
          response.status = current_exchange->status = 500;
          response.set_content(R"({"type":")" + edge_.options.base_path +
                                   R"(/docs/errors/#internal","status":500,"code":"internal"})",
                               std::string(kProblemMediaType));
          current_exchange->reply_body.reset();
          current_exchange->reply_file.reset();
          current_exchange->close = true;
        });
  }

  Result<int> start() {
    const HttpOptions& options = edge_.options;
    const int port = options.port == 0                          ? bind_to_any_port(options.host)
                     : bind_to_port(options.host, options.port) ? options.port
                                                                : -1;
    if (port < 0) {
      const std::string reason =
          bind_errno_ != 0 ? std::strerror(bind_errno_) : "the host name cannot be resolved";
      return fail(ErrorCode::internal,
                  fmt::format("cannot listen on {}:{}: {}", options.host, options.port, reason));
    }
    if (auto started = workers_.start(); !started) return fail(std::move(started.error()));
    try {
      listener_ = std::thread([this, port] { listen(port); });
    } catch (const std::system_error& error) {
      return fail(ErrorCode::internal, fmt::format("no thread can be started: {}", error.what()));
    }
    return port;
  }

  bool stop(std::chrono::milliseconds grace) {
    const std::lock_guard one_at_a_time(stop_mutex_);
    if (!listener_.joinable()) return true;
    edge_.stopping = true;
    acceptor_.stop();
    // Not httplib's stop(): that makes it truncate replies on their way. This
    // merely ends accept().
    ::shutdown(svr_sock_, SHUT_RDWR);
    listener_.join();
    ::close(svr_sock_);  // who connects now is refused
    return workers_.stop(grace);
  }

  void close_after_replies() { edge_.parting = true; }

  void set_patience(const HttpPatience& patience) {
    edge_.keep_alive = patience.keep_alive;
    edge_.body_timeout = patience.body_timeout;
    edge_.min_receive_rate = patience.min_receive_rate;
  }

  void set_max_replies_in_flight(std::uint64_t bytes) { edge_.replies.set_most(bytes); }

  Stats stats() const {
    Stats stats;
    stats.connections = workers_.connections();
    stats.dispensable = workers_.dispensable();
    stats.threads = workers_.threads();
    stats.running = running_;
    stats.requests = edge_.requests;
    stats.body_bytes = edge_.bodies.bytes();
    stats.accept_failures = acceptor_.failures();
    stats.is_accepting = acceptor_.is_accepting();
    return stats;
  }

 private:
  // Its own thread.
  void listen(int port) {
    const std::string reason = acceptor_.run(svr_sock_, [this](UniqueFd connection) {
      const int on = 1;
      ::setsockopt(connection.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      workers_.adopt(std::move(connection));
    });
    if (reason.empty()) return;
    spdlog::critical("the listening socket on port {} failed: {}", port, reason);
    edge_.options.failed(reason);
  }

  // Connections are accepted elsewhere.
  bool process_and_close_socket(socket_t) override { return false; }

  // Has a complete request answered; its reply is then on the connection's queue.
  void answer(Exchange& exchange) {
    current_exchange = &exchange;
    ReplyStream stream(exchange, edge_.options);
    bool ignored = false;
    const bool written = process_request(stream, "", 0, "", 0, exchange.close, ignored, nullptr);
    current_exchange = nullptr;
    exchange.failed = !written;
    if (written && exchange.reply_body) exchange.connection.queue(std::move(exchange.reply_body));
    if (written && exchange.reply_file) exchange.connection.queue(std::move(exchange.reply_file));
  }

  HttpResponse handle(Exchange& exchange) {
    HttpRequest& request = exchange.request;
    if (exchange.refused) {
      return HttpResponse::problem(exchange.refused->error, request, exchange.refused->status);
    }
    const Counted counted(running_);
    try {
      return handler_(request);
    } catch (const std::exception& thrown) {
      spdlog::error("{} the handler threw: {}", request.id, for_log(thrown.what()));
    } catch (...) {
      spdlog::error("{} the handler threw something that is no exception", request.id);
    }
    return HttpResponse::problem(Error{ErrorCode::internal, "internal error", {}, {}, {}}, request);
  }

  // Our reply to httplib's.
  void hand_over(HttpResponse reply, Exchange& exchange, httplib::Response& response) {
    const bool is_head = exchange.request.method == "HEAD";
    const bool bodiless = reply.status == 204 || reply.status == 304;
    const std::string& client = exchange.request.caller.client;
    if (reply.stream && !is_head && !bodiless) {
      // A streamed reply holds a thread.
      if (auto begun = edge_.streams.take(client, 1); !begun) {
        reply = HttpResponse::problem(begun.error(), exchange.request);
      }
    }
    if (reply.file) reply.body = nullptr;
    // Clients that do not take what they asked for must not fill the memory with it.
    if (reply.body && !reply.reserved && !is_head && reply.body->size() > kSmallReply) {
      if (auto charged = edge_.replies.take(client, reply.body->size()); charged) {
        exchange.reply_charged = reply.body->size();
      } else {
        reply = HttpResponse::problem(charged.error(), exchange.request);
      }
    }
    exchange.status = response.status = reply.status;
    exchange.route = std::move(reply.route);
    std::string spare_name;
    std::string spare_value;
    for (const auto& [name, value] : reply.headers) {
      if (is_of_edge(name)) continue;
      response.set_header(without_controls(name, spare_name), without_controls(value, spare_value));
    }
    const bool has_content = reply.stream || reply.file || (reply.body && !reply.body->empty());
    const std::string type = reply.content_type.empty()
                                 ? "application/octet-stream"
                                 : without_controls(reply.content_type, spare_value);
    if (reply.stream && !is_head && !bodiless) {
      stream(reply, type, exchange, response);
    } else if (bodiless || reply.stream) {
      if (!bodiless) response.set_header("Content-Type", type);
      exchange.omit_length = true;
    } else if (has_content) {
      response.set_header("Content-Type", type);
      response.set_header("Content-Length",
                          std::to_string(reply.file ? reply.file->size() : reply.body->size()));
      if (is_head) return;
      // Follows the head by itself: it is not copied, and no thread waits for it.
      exchange.reply_body = std::move(reply.body);
      exchange.reply_file = std::move(reply.file);
      exchange.reply_reserved = std::move(reply.reserved);
    }
  }

  void stream(HttpResponse& reply, const std::string& type, Exchange& exchange,
              httplib::Response& response) {
    exchange.streams = true;
    auto send = [this, next = std::move(reply.stream), broken = std::move(reply.broken),
                 id = exchange.request.id](std::size_t, httplib::DataSink& sink) {
      try {
        std::string chunk;
        if (!next(chunk)) {
          if (broken && *broken) {
            // A client that is gone needs no word.
            if ((*broken)->code != ErrorCode::cancelled) {
              spdlog::warn("{} a streamed reply is broken off: {}", id, (*broken)->detail);
            }
            return false;
          }
          sink.done();
          return true;
        }
        // The pieces' own deadlines would add up to more.
        const Clock::time_point deadline = sent_by(edge_.options, chunk.size());
        for (std::size_t sent = 0; sent < chunk.size(); sent += kChunkPiece) {
          if (Clock::now() >= deadline) return false;
          if (!sink.write(chunk.data() + sent, std::min(kChunkPiece, chunk.size() - sent)))
            return false;
        }
        return true;
      } catch (const std::exception& thrown) {
        // The status is sent: all that is left is an end that nobody takes for the end.
        spdlog::error("{} a streamed reply threw: {}", id, for_log(thrown.what()));
        return false;
      }
    };
    const auto end = [this, client = exchange.request.caller.client](bool) {
      edge_.streams.give_back(client, 1);
    };
    if (exchange.head.http_1_0) {  // knows no chunks: the end is the connection's
      response.set_content_provider(type, std::move(send), end);
      exchange.omit_length = exchange.close = true;
    } else {
      response.set_chunked_content_provider(type, std::move(send), end);
    }
  }

  // The last word on the headers: what httplib added is corrected.
  void finish_headers(Exchange& exchange, httplib::Response& response) const {
    response.headers.erase("Connection");
    response.headers.erase("Keep-Alive");
    if (exchange.omit_length) response.headers.erase("Content-Length");
    exchange.close = exchange.close || edge_.parting || edge_.stopping;
    if (exchange.close) response.set_header("Connection", "close");
    response.set_header("X-Request-Id", exchange.request.id);
    response.set_header("Date", http_date());
  }

  const HttpHandler handler_;
  HttpEdge edge_;
  HttpWorkers workers_;
  HttpListener acceptor_;
  int bind_errno_ = 0;
  std::thread listener_;
  std::mutex stop_mutex_;
  std::atomic<std::uint64_t> running_{0};
};

HttpServer::HttpServer(HttpOptions options, HttpHandler handler)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(handler))) {}

HttpServer::~HttpServer() { impl_->stop(std::chrono::milliseconds(0)); }

Result<int> HttpServer::start() { return impl_->start(); }

bool HttpServer::stop(std::chrono::milliseconds grace) { return impl_->stop(grace); }

void HttpServer::close_after_replies() { impl_->close_after_replies(); }

void HttpServer::set_patience(const HttpPatience& patience) { impl_->set_patience(patience); }

void HttpServer::set_max_replies_in_flight(std::uint64_t bytes) {
  impl_->set_max_replies_in_flight(bytes);
}

HttpServer::Stats HttpServer::stats() const { return impl_->stats(); }

}  // namespace geodesic::server
