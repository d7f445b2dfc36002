// The life of one connection, as steps that never wait for the peer: what a proxy announces, and
// handshake, then heads, bodies and replies, then goodbye. `advance` goes as far as the bytes
// that are there allow, and says what it would wait for and how long. So a client
// that is idle or slow, whether in its head, its body or in taking a reply, holds
// memory but no thread. A thread is held by the handler, and by a reply that is
// streamed.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/base/client_shares.h"
#include "server/edge/body.h"
#include "server/edge/body_budget.h"
#include "server/edge/connection.h"
#include "server/edge/exchange.h"
#include "server/edge/options.h"
#include "server/proxies/proxy_header.h"

namespace geodesic::server {

// Connections that were closed for what a proxy announced of them, or did not.
class Unannounced {
 public:
  // Tells the log, at most once a second: anybody can make many. Any thread.
  void tell(const std::string& peer, std::string_view why);

 private:
  using Clock = std::chrono::steady_clock;
  std::atomic<std::uint64_t> count_{0};
  std::atomic<Clock::time_point> told_{Clock::time_point::min()};
};

// What all connections of a listener share.
struct HttpEdge {
  HttpOptions options;
  // Has the request answered, and queues the reply's bytes on its connection.
  std::function<void(Exchange&)> answer;
  // Of the options, those that may have changed since: asked here.
  std::atomic<std::chrono::milliseconds> keep_alive{options.keep_alive};
  std::atomic<std::chrono::milliseconds> body_timeout{options.body_timeout};
  std::atomic<std::uint64_t> min_receive_rate{options.min_receive_rate};
  std::atomic<bool> parting{false};  // each reply is the last of its connection
  std::atomic<bool> stopping{false};
  std::atomic<std::uint64_t> requests{0};  // answered since the start
  BodyBudget bodies{options.max_bodies_in_flight, options.receive_grace};
  // Bytes that are not sent yet, and replies that are streamed.
  ClientShares replies{options.max_replies_in_flight, "replies wait for their clients"};
  ClientShares streams{options.max_io_threads / 2 + 1, "replies are being streamed"};
  Unannounced unannounced{};
};

class HttpConversation {
 public:
  using Clock = HttpConnection::Clock;

  // `unwanted` is set when its body is to go for others'. Both must outlive it.
  HttpConversation(HttpEdge& edge, UniqueFd socket, std::unique_ptr<TlsSession> tls,
                   std::atomic<bool>& unwanted);
  ~HttpConversation();
  HttpConversation(const HttpConversation&) = delete;
  HttpConversation& operator=(const HttpConversation&) = delete;

  enum class WaitsFor : std::uint8_t { readable, writable, nothing };
  struct Next {
    WaitsFor what = WaitsFor::nothing;  // `nothing`: it is over
    Clock::time_point deadline = Clock::time_point::max();
    bool idle = false;         // between requests: nobody misses it
    bool dispensable = false;  // or before one is complete: can be pushed out
  };
  // To be called when what it waits for has come or, with `overdue`, when its time
  // is over (or it is pushed out).
  [[nodiscard]] Next advance(bool overdue);
  // It is nobody's to serve: closed at once where no proxy may have made it.
  [[nodiscard]] bool is_over() const { return phase_ == Phase::over; }

  [[nodiscard]] const HttpConnection& connection() const { return connection_; }

 private:
  enum class Phase : std::uint8_t {
    announcement,
    handshake,
    head,
    body,
    reply,
    sending,
    goodbye,
    over
  };

  // Each does what is possible now; empty: the next phase goes on at once.
  using MaybeNext = std::optional<Next>;
  MaybeNext receive_announcement(bool overdue);
  MaybeNext shake_hands(bool overdue);
  MaybeNext receive_head(bool overdue);
  MaybeNext receive_body(bool overdue);
  MaybeNext send_reply(bool overdue);
  MaybeNext part(bool overdue);

  void begin_body();
  void refuse_body(Error error);
  void answer();
  void finish(bool sent);
  [[nodiscard]] Clock::time_point body_deadline() const;
  void release_reply();
  [[nodiscard]] static Next wait_for(Progress progress, Clock::time_point deadline);
  MaybeNext go(Phase phase) {
    phase_ = phase;
    return {};
  }

  HttpEdge& edge_;
  HttpConnection connection_;
  std::string remote_;  // the socket's peer, or whom it speaks for
  Phase phase_ = Phase::handshake;
  std::size_t count_ = 0;       // of requests
  Clock::time_point deadline_;  // of the phase
  Clock::time_point stalled_;   // of the next byte sent
  bool head_begun_ = false;     // its first byte is there
  ProxyHeader announced_;
  std::optional<Exchange> exchange_;
  std::optional<HttpBody> body_;
  BodyBudget::Part held_;  // of the bodies in flight
  std::uint64_t sent_before_ = 0;
};

}  // namespace geodesic::server
