#include "server/http_server.h"

// Connections wait here, not in the kernel, for the accepting thread.
#define CPPHTTPLIB_LISTEN_BACKLOG 1024
#include <httplib.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <ctime>
#include <deque>
#include <limits>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>

#include "server/http_connection.h"
#include "server/http_exchange.h"
#include "server/http_head.h"
#include "server/problem.h"
#include "server/request_log.h"

// How cpp-httplib is used. It accepts, keeps the threads, decodes bodies and
// writes replies. It does not see what clients send as a head: that is read by
// `parse_head`, strictly and with raw values, and cpp-httplib gets a head of our
// own in its place that says how long the body is and nothing else. So none of
// its conveniences (form parsing, ranges, WebSockets, decoded header values,
// replies of its own) can be reached from outside, and every request, whatever
// its method and path, arrives at one place below.

namespace geodesic::server {

namespace {

using Clock = HttpConnection::Clock;

// A connection stays on one thread from accept to close, so cpp-httplib's
// callbacks find its exchange in a variable of that thread.
thread_local Exchange* current_exchange = nullptr;

std::string without_controls(std::string_view text) {
  std::string out(text);
  std::erase_if(
      out, [](char c) { return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f; });
  return out;
}

// Headers of a reply that the edge sets itself.
bool is_ours(std::string_view name) {
  for (const std::string_view ours : {"Content-Length", "Content-Type", "Transfer-Encoding",
                                      "Connection", "Keep-Alive", "Date", "X-Request-Id"}) {
    if (equals_ignoring_case(name, ours)) return true;
  }
  return false;
}

std::string http_date() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[64];
  const std::size_t size = std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &utc);
  return std::string(text, size);
}

// What cpp-httplib reads: our head first, then the client's body.
class BodyStream final : public httplib::Stream {
 public:
  BodyStream(HttpConnection& connection, std::string head)
      : connection_(connection), head_(std::move(head)) {}

  bool is_readable() const override { return head_used_ < head_.size(); }
  bool wait_readable() const override { return true; }  // `read` waits
  bool wait_writable() const override { return true; }  // `write` waits
  bool is_peer_alive() const override { return true; }  // `write` finds out

  ssize_t read(char* out, std::size_t size) override {
    const std::size_t n = std::min(size, head_.size() - head_used_);
    if (n == 0) return connection_.read(out, size);
    std::memcpy(out, head_.data() + head_used_, n);
    head_used_ += n;
    return static_cast<ssize_t>(n);
  }
  ssize_t write(const char* data, std::size_t size) override {
    return size == 0 ? 0 : connection_.write(data, size);
  }
  using httplib::Stream::write;

  // The addresses are asked of the socket before there is a stream.
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return connection_.socket(); }
  time_t duration() const override { return 0; }

 private:
  HttpConnection& connection_;
  const std::string head_;
  std::size_t head_used_ = 0;
};

}  // namespace

class HttpServer::Impl final : public httplib::Server {
 public:
  Impl(HttpOptions options, HttpHandler handler)
      : options_(std::move(options)), handler_(std::move(handler)) {
    set_tcp_nodelay(true);
    // Only SO_REUSEADDR: with SO_REUSEPORT a second server would start silently.
    set_socket_options([](socket_t socket) {
      const int on = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    });
    set_payload_max_length(std::numeric_limits<std::size_t>::max());  // ours is per route
    set_error_logger([this](const httplib::Error& error, const httplib::Request*) {
      // Called right after the system call that failed.
      if (error == httplib::Error::BindIPAddress || error == httplib::Error::Listen) {
        bind_errno_ = errno;
      }
    });
    new_task_queue = [this] { return new ConnectionQueue(*this); };
    Post("/", [this](const httplib::Request&, httplib::Response& response,
                     const httplib::ContentReader& body) {
      Exchange& exchange = *current_exchange;
      hand_over(answer(exchange, body), exchange, response);
    });
    set_post_routing_handler([this](const httplib::Request&, httplib::Response& response) {
      finish_headers(*current_exchange, response);
    });
    // Out of memory while a reply is being put together; nothing else throws there.
    set_exception_handler(
        [](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
          response.headers.clear();
          response.status = current_exchange->status = 500;
          response.set_content(R"({"type":"/problems/internal","status":500,"code":"internal"})",
                               std::string(problem_media_type));
          current_exchange->close = true;
        });
  }

  Result<int> start() {
    const int port = options_.port == 0                           ? bind_to_any_port(options_.host)
                     : bind_to_port(options_.host, options_.port) ? options_.port
                                                                  : -1;
    if (port < 0) {
      const std::string reason =
          bind_errno_ != 0 ? std::strerror(bind_errno_) : "the host name cannot be resolved";
      return fail(ErrorCode::internal,
                  fmt::format("cannot listen on {}:{}: {}", options_.host, options_.port, reason));
    }
    listener_ = std::thread([this] {
      listen_after_bind();
      if (!stopping_) spdlog::critical("the listening socket on port {} failed", options_.port);
      const std::lock_guard lock(mutex_);
      ended_ = true;
      ended_signal_.notify_all();
    });
    wait_until_ready();
    return port;
  }

  bool stop(std::chrono::milliseconds grace) {
    const std::lock_guard one_at_a_time(stop_mutex_);
    if (!listener_.joinable()) return true;
    stopping_ = true;
    // Not httplib's stop(): that makes it truncate replies on their way. This
    // merely ends accept(); the listening thread then waits for all others.
    ::shutdown(svr_sock_, SHUT_RDWR);
    bool clean;
    {
      std::unique_lock lock(mutex_);
      clean = ended_signal_.wait_for(lock, grace, [&] { return ended_; });
      // Again and again: connections that waited for a thread come up only now.
      while (!ended_) {
        for (const auto& peer : peers_) peer->cut();
        ended_signal_.wait_for(lock, std::chrono::milliseconds(20), [&] { return ended_; });
      }
    }
    listener_.join();
    return clean;
  }

  Stats stats() const {
    Stats stats;
    {
      const std::lock_guard lock(waiting_mutex_);
      stats.waiting = waiting_since_.size();
    }
    stats.connections = stats.waiting + served_;
    stats.running = running_;
    stats.requests = requests_;
    stats.body_bytes = body_bytes_;
    return stats;
  }

 private:
  // httplib's pool, counted, so that pressure can be felt.
  class ConnectionQueue final : public httplib::TaskQueue {
   public:
    explicit ConnectionQueue(Impl& server)
        : server_(server),
          pool_(server.options_.io_threads,
                std::max(server.options_.io_threads, server.options_.max_io_threads),
                server.options_.max_waiting) {}
    bool enqueue(std::function<void()> serve) override {
      server_.begin_waiting();
      try {
        const bool taken = pool_.enqueue([this, serve = std::move(serve)] {
          server_.end_waiting(/*oldest=*/true);
          serve();
        });
        if (!taken) {
          server_.end_waiting(/*oldest=*/false);
          spdlog::warn("too many connections wait for a thread: one is closed");
        }
        return taken;
      } catch (const std::system_error& error) {
        // The pool could not start another thread. The connection is in its
        // queue nevertheless and will be served by one that it has.
        spdlog::warn("no further thread for connections: {}", error.what());
        return true;
      }
    }
    void shutdown() override { pool_.shutdown(); }

   private:
    Impl& server_;
    httplib::ThreadPool pool_;
  };

  // Counts for as long as it lives.
  struct Counted {
    std::atomic<std::uint64_t>& counter;
    explicit Counted(std::atomic<std::uint64_t>& c) : counter(c) { ++counter; }
    ~Counted() { --counter; }
    Counted(const Counted&) = delete;
  };

  // The pool's queue is first in, first out; so is this record of it.
  void begin_waiting() {
    const std::lock_guard lock(waiting_mutex_);
    waiting_since_.push_back(Clock::now());
  }
  void end_waiting(bool oldest) {
    const std::lock_guard lock(waiting_mutex_);
    if (oldest) {
      waiting_since_.pop_front();
    } else {
      waiting_since_.pop_back();
    }
  }
  // Connections wait for a thread, and not just for one to wake up: threads
  // must not be spent on idle ones.
  bool under_pressure() const {
    constexpr std::chrono::milliseconds wake_up{20};
    const std::lock_guard lock(waiting_mutex_);
    return !waiting_since_.empty() && Clock::now() - waiting_since_.front() > wake_up;
  }

  bool process_and_close_socket(socket_t socket) override {
    const Counted counted(served_);
    HttpConnection connection(socket);
    {
      const std::lock_guard lock(mutex_);
      peers_.insert(connection.watch());
    }
    bool unread = false;
    try {
      unread = serve(connection);
    } catch (const std::exception& thrown) {  // out of memory
      spdlog::error("a connection was given up: {}", thrown.what());
    }
    connection.linger(unread);
    const std::lock_guard lock(mutex_);
    peers_.erase(connection.watch());
    return true;
  }

  // One request after the other. Returns whether more of the last may come.
  bool serve(HttpConnection& connection) {
    const std::string remote = connection.peer_address();
    for (std::size_t count = 1;; ++count) {
      const auto accepted = Clock::now();
      const bool ready = connection.wait_for_request(options_.keep_alive, [&] {
        // A new client is given time for its first request even under pressure.
        const bool new_client = count == 1 && Clock::now() - accepted < std::chrono::seconds(1);
        return stopping_ || (!new_client && under_pressure());
      });
      if (!ready) return false;

      Exchange exchange{connection};
      exchange.request.remote = remote;
      if (!receive_head(options_, exchange)) return false;
      exchange.close =
          exchange.refused || !exchange.head.keep_alive || count >= options_.keep_alive_count;
      const bool sent = respond(exchange);
      if (!sent || exchange.close) return exchange.body_unread;
    }
  }

  // Has the request answered and the reply written; false if it could not be.
  bool respond(Exchange& exchange) {
    const HttpHead& head = exchange.head;
    const bool has_body = !exchange.refused && (head.chunked || head.body_bytes > 0);
    std::string stand_in = "POST / HTTP/1.1\r\n";
    if (has_body && head.chunked) {
      stand_in += "Transfer-Encoding: chunked\r\n";
    } else {
      stand_in += fmt::format("Content-Length: {}\r\n", has_body ? head.body_bytes : 0);
    }
    if (has_body && head.expects_continue) stand_in += "Expect: 100-continue\r\n";
    stand_in += "\r\n";

    BodyStream stream(exchange.connection, std::move(stand_in));
    struct Cleanup {
      Impl& server;
      Exchange& exchange;
      ~Cleanup() {
        current_exchange = nullptr;
        server.release_body(exchange);
      }
    } const cleanup{*this, exchange};
    current_exchange = &exchange;
    // Until the handler has answered, only "100 Continue" is written.
    exchange.connection.set_write_limits(options_.write_timeout,
                                         Clock::now() + options_.write_timeout);
    const std::uint64_t sent_before = exchange.connection.bytes_sent();
    bool unread = false;
    const bool sent =
        process_request(stream, exchange.request.remote, 0, "", 0, exchange.close, unread, nullptr);
    exchange.close = exchange.close || unread;
    ++requests_;
    const std::chrono::duration<double, std::milli> taken = Clock::now() - exchange.begin;
    log_request(exchange.request, exchange.route, exchange.status,
                exchange.connection.bytes_sent() - sent_before, taken.count(), sent);
    return sent;
  }

  HttpResponse answer(Exchange& exchange, const httplib::ContentReader& body) {
    HttpRequest& request = exchange.request;
    if (!exchange.refused && (exchange.head.chunked || exchange.head.body_bytes > 0)) {
      exchange.refused = receive_body(exchange, body);
      if (exchange.refused) {
        exchange.close = exchange.body_unread = true;
        exchange.connection.refuse_reads();
        request.body = {};
        release_body(exchange);
      }
    }
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

  std::optional<HeadError> receive_body(Exchange& exchange, const httplib::ContentReader& body) {
    const std::uint64_t limit = exchange.body_limit;
    std::string& bytes = exchange.request.body;
    bool over_limit = false;
    bool crowded = false;
    exchange.connection.set_read_deadline(Clock::now() + options_.body_timeout);
    const bool complete = body([&](const char* data, std::size_t size) {
      over_limit = size > limit - bytes.size();
      if (over_limit) return false;
      exchange.charged += size;
      const std::uint64_t in_flight = body_bytes_ += size;
      crowded = options_.max_bodies_in_flight != 0 && in_flight > options_.max_bodies_in_flight;
      if (crowded) return false;
      if (bytes.size() + size > bytes.capacity()) {
        // What was declared, but not much more than what came: a promise costs nothing.
        const std::uint64_t promised = exchange.head.chunked ? limit : exchange.head.body_bytes;
        bytes.reserve(
            std::min<std::uint64_t>(promised, std::max<std::uint64_t>(1u << 16, 4 * bytes.size())));
      }
      bytes.append(data, size);
      return true;
    });
    if (complete) return {};
    if (over_limit) {
      return HeadError{Error{ErrorCode::too_large, "the body is too large", {}, limit, {}}};
    }
    if (crowded) {
      return HeadError{
          Error{ErrorCode::overloaded, "too many bodies are being received", {}, {}, {}}};
    }
    if (exchange.connection.timed_out()) {
      return HeadError{
          Error{ErrorCode::request_timeout, "the body did not arrive in time", {}, {}, {}}};
    }
    if (exchange.connection.closed()) {
      return HeadError{
          Error{ErrorCode::cancelled, "the client left before its body was complete", {}, {}, {}}};
    }
    return HeadError{
        Error{ErrorCode::bad_syntax, "the chunks of the body do not parse", {}, {}, {}}};
  }

  void release_body(Exchange& exchange) { body_bytes_ -= std::exchange(exchange.charged, 0); }

  // Our reply to httplib's.
  void hand_over(HttpResponse reply, Exchange& exchange, httplib::Response& response) {
    const bool is_head = exchange.request.method == "HEAD";
    const bool bodiless = reply.status == 204 || reply.status == 304;
    exchange.status = response.status = reply.status;
    exchange.route = std::move(reply.route);
    for (const auto& [name, value] : reply.headers) {
      if (!is_ours(name)) response.set_header(without_controls(name), without_controls(value));
    }
    const bool has_content = reply.stream || (reply.body && !reply.body->empty());
    const std::string type = reply.content_type.empty() ? "application/octet-stream"
                                                        : without_controls(reply.content_type);
    // Otherwise it comes with the content provider.
    if (has_content && is_head && !bodiless) response.set_header("Content-Type", type);

    if (bodiless || (is_head && reply.stream)) {
      exchange.omit_length = true;
    } else if (reply.stream) {
      const auto send = [this, &exchange, next = std::move(reply.stream)](std::size_t,
                                                                          httplib::DataSink& sink) {
        std::string chunk;
        if (!next(chunk)) {
          sink.done();
          return true;
        }
        limit_write(exchange, chunk.size());
        return chunk.empty() || sink.write(chunk.data(), chunk.size());
      };
      if (exchange.head.http_1_0) {  // knows no chunks: the end is the connection's
        response.set_content_provider(type, send);
        exchange.omit_length = true;
      } else {
        response.set_chunked_content_provider(type, send);
      }
    } else if (has_content) {
      exchange.reply_bytes = reply.body->size();
      if (is_head) {
        response.set_header("Content-Length", std::to_string(reply.body->size()));
      } else {
        // In one piece, so that httplib does not look at its state in between.
        response.set_content_provider(
            reply.body->size(), type,
            [body = reply.body](std::size_t offset, std::size_t size, httplib::DataSink& sink) {
              return sink.write(body->data() + offset, size);
            });
      }
    }
  }

  // The last word on the headers: what httplib added is corrected.
  void finish_headers(Exchange& exchange, httplib::Response& response) {
    response.headers.erase("Connection");
    response.headers.erase("Keep-Alive");
    if (exchange.omit_length) response.headers.erase("Content-Length");
    exchange.close = exchange.close || stopping_ || under_pressure();
    if (exchange.close) response.set_header("Connection", "close");
    response.set_header("X-Request-Id", exchange.request.id);
    response.set_header("Date", http_date());
    limit_write(exchange, exchange.reply_bytes);
  }

  void limit_write(Exchange& exchange, std::uint64_t bytes) const {
    Clock::time_point deadline = Clock::now() + options_.write_timeout;
    if (options_.min_send_rate != 0) {
      deadline += std::chrono::seconds(bytes / options_.min_send_rate);
    } else {
      deadline = Clock::time_point::max();
    }
    exchange.connection.set_write_limits(options_.write_timeout, deadline);
  }

  const HttpOptions options_;
  const HttpHandler handler_;
  int bind_errno_ = 0;
  std::thread listener_;
  std::mutex stop_mutex_;
  std::atomic<bool> stopping_{false};

  mutable std::mutex mutex_;
  std::condition_variable ended_signal_;
  bool ended_ = false;                          // guarded by mutex_
  std::set<std::shared_ptr<PeerWatch>> peers_;  // guarded by mutex_

  mutable std::mutex waiting_mutex_;
  std::deque<Clock::time_point> waiting_since_;

  std::atomic<std::uint64_t> served_{0};  // connections that have a thread
  std::atomic<std::uint64_t> running_{0};
  std::atomic<std::uint64_t> requests_{0};
  std::atomic<std::uint64_t> body_bytes_{0};
};

HttpServer::HttpServer(HttpOptions options, HttpHandler handler)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(handler))) {}

HttpServer::~HttpServer() { impl_->stop(std::chrono::milliseconds(0)); }

Result<int> HttpServer::start() { return impl_->start(); }

bool HttpServer::stop(std::chrono::milliseconds grace) { return impl_->stop(grace); }

HttpServer::Stats HttpServer::stats() const { return impl_->stats(); }

}  // namespace geodesic::server
