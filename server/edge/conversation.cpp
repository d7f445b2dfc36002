#include "server/edge/conversation.h"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <utility>

#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"
#include "server/http/request_log.h"

namespace geodesic::server {

namespace {

constexpr std::size_t kProxyChunk = 4u << 10;
constexpr std::size_t kHeadChunk = 16u << 10;
constexpr std::size_t kBodyChunk = 64u << 10;
// What is read of a body after its time, which is more than a socket holds. A piece counts as
// so much at least: a TLS record may have a single byte.
constexpr std::size_t kLateBytes = 16u << 20;
constexpr std::size_t kLeastPiece = 1u << 10;
// After a last reply: for how long, and how many bytes at a time, what still comes
// is taken. Closing with unread bytes would reset the connection and may destroy
// the reply on its way.
constexpr std::chrono::seconds kGoodbyeTime{1};
constexpr std::size_t kGoodbyeChunk = 1u << 20;
constexpr std::chrono::seconds kTellUnannouncedEvery{1};

}  // namespace

void Unannounced::tell(const std::string& peer, std::string_view why) {
  const std::uint64_t count = ++count_;
  const Clock::time_point now = Clock::now();
  Clock::time_point told = told_;
  if (told != Clock::time_point::min() && now - told < kTellUnannouncedEvery) return;
  if (!told_.compare_exchange_strong(told, now)) return;  // another thread does
  spdlog::warn("a connection from {} is closed: {} ({} so far)", peer, why, count);
}

HttpConversation::HttpConversation(HttpEdge& edge, UniqueFd socket, std::unique_ptr<TlsSession> tls,
                                   std::atomic<bool>& unwanted)
    : edge_(edge),
      connection_(std::move(socket), std::move(tls)),
      remote_(connection_.peer_address()),
      deadline_(Clock::now() + edge.options.head_timeout),
      held_(edge.bodies, unwanted) {
  if (!edge.options.expects_proxy_header) return;
  phase_ = Phase::announcement;
  if (edge.options.trusted_proxies.contains(remote_)) return;
  edge.unannounced.tell(remote_, "it is no address of trusted-proxies, and --proxy-protocol is on");
  phase_ = Phase::over;
}

HttpConversation::~HttpConversation() { release_reply(); }

auto HttpConversation::wait_for(Progress progress, Clock::time_point deadline) -> Next {
  return {progress == Progress::wants_write ? WaitsFor::writable : WaitsFor::readable, deadline,
          false, false};
}

auto HttpConversation::advance(bool overdue) -> Next {
  while (true) {
    MaybeNext next;
    switch (phase_) {
      case Phase::announcement:
        next = receive_announcement(overdue);
        break;
      case Phase::handshake:
        next = shake_hands(overdue);
        break;
      case Phase::head:
        next = receive_head(overdue);
        break;
      case Phase::body:
        next = receive_body(overdue);
        break;
      case Phase::reply:
        answer();
        break;
      case Phase::sending:
        next = send_reply(overdue);
        break;
      case Phase::goodbye:
        next = part(overdue);
        break;
      case Phase::over:
        return {};
    }
    if (next) return *next;
    overdue = false;  // it was about the phase that is over now
  }
}

// Never reads beyond the header: what follows may be TLS.
auto HttpConversation::receive_announcement(bool overdue) -> MaybeNext {
  while (true) {
    std::array<char, kProxyChunk> bytes;
    std::size_t count = 0;
    const Progress progress =
        connection_.read_plain(bytes.data(), std::min(bytes.size(), announced_.missing()), count);
    if (progress == Progress::closed) return go(Phase::over);
    if (progress == Progress::done) {
      const ProxyHeader::State state = announced_.take({bytes.data(), count});
      if (state == ProxyHeader::State::more) continue;
      if (state == ProxyHeader::State::refused) {
        edge_.unannounced.tell(remote_, announced_.fault());
        return go(Phase::over);
      }
      if (!announced_.source().empty()) remote_ = announced_.source();
      return go(Phase::handshake);
    }
    if (overdue || Clock::now() > deadline_) {
      if (announced_.has_begun()) {
        edge_.unannounced.tell(remote_, "its PROXY header did not arrive in time");
      }
      return go(Phase::over);
    }
    Next next = wait_for(progress, deadline_);
    next.idle = !announced_.has_begun();
    next.dispensable = true;
    return next;
  }
}

auto HttpConversation::shake_hands(bool overdue) -> MaybeNext {
  if (overdue) return go(Phase::over);
  const Progress progress = connection_.handshake();
  if (progress == Progress::closed) return go(Phase::over);
  if (progress != Progress::done) {
    Next next = wait_for(progress, deadline_);
    next.dispensable = true;
    return next;
  }
  deadline_ = Clock::now() + edge_.keep_alive.load();
  return go(Phase::head);
}

auto HttpConversation::receive_head(bool overdue) -> MaybeNext {
  // Empty lines before a head are no part of it, so the bound on its size does not end them.
  const std::size_t most_bytes = 2 * edge_.options.max_head_bytes + kHeadChunk;
  std::size_t bytes = 0;
  while (true) {
    std::size_t size = 0;
    const auto outcome =
        connection_.find_head(edge_.options.max_target_bytes, edge_.options.max_head_bytes, size);
    if (size > 0 && !head_begun_) {
      head_begun_ = true;
      deadline_ = Clock::now() + edge_.options.head_timeout;
    }
    // What has arrived is read before time is judged, for it may be the server that was late. Time
    // counts even while bytes come: a trickle must not outlive the deadline.
    Progress progress = Progress::done;
    if (outcome == HttpConnection::Head::incomplete) {
      const std::size_t had = connection_.arrived().size();
      progress = connection_.receive(kHeadChunk);
      bytes += connection_.arrived().size() - had;
      if (progress == Progress::done && bytes <= most_bytes) continue;
      if (progress == Progress::done) return go(Phase::over);
      if (progress == Progress::closed) return go(Phase::over);  // there is nobody to answer
    }
    const bool late = overdue || Clock::now() > deadline_;
    if (progress == Progress::done || (late && head_begun_)) {
      exchange_.emplace(connection_);
      judge_head(edge_.options, outcome, connection_.arrived().substr(0, size), remote_,
                 *exchange_);
      connection_.use(size);
      head_begun_ = false;
      ++count_;
      if (count_ >= edge_.options.keep_alive_count) exchange_->close = true;
      sent_before_ = connection_.bytes_sent();
      const HttpHead& head = exchange_->head;
      if (exchange_->refused || (!head.chunked && head.body_bytes == 0)) return go(Phase::reply);
      if (!edge_.options.wants_body(exchange_->request)) {
        exchange_->close = exchange_->body_unread = true;
        return go(Phase::reply);
      }
      begin_body();
      return go(Phase::body);
    }
    if (late) return go(Phase::over);
    Next next = wait_for(progress, deadline_);
    next.idle = !head_begun_;
    next.dispensable = true;
    return next;
  }
}

void HttpConversation::begin_body() {
  const HttpHead& head = exchange_->head;
  held_.begin(exchange_->request.caller.client);
  body_ =
      head.chunked ? HttpBody::chunked(exchange_->body_limit) : HttpBody::counted(head.body_bytes);
  if (head.expects_continue && connection_.arrived().empty()) {
    // Those few bytes find room in any socket; if not, they go with the reply.
    connection_.queue("HTTP/1.1 100 Continue\r\n\r\n");
    (void)connection_.send();
  }
}

auto HttpConversation::body_deadline() const -> Clock::time_point {
  const std::chrono::milliseconds timeout = edge_.body_timeout;
  const std::uint64_t rate = edge_.min_receive_rate;
  Clock::time_point deadline = exchange_->begin + timeout;
  if (rate != 0) {
    const std::chrono::duration<double> bought(static_cast<double>(exchange_->request.body.size()) /
                                               static_cast<double>(rate));
    const std::chrono::duration<double> most = timeout;
    deadline =
        std::min(deadline, exchange_->begin + edge_.options.receive_grace +
                               std::chrono::duration_cast<Clock::duration>(std::min(bought, most)));
  }
  return deadline;
}

auto HttpConversation::receive_body(bool overdue) -> MaybeNext {
  std::size_t late_bytes = 0;
  while (true) {
    std::string& bytes = exchange_->request.body;
    std::string_view arrived = connection_.arrived();
    const std::size_t had = arrived.size();
    const HttpBody::State state = body_->take(arrived, bytes);
    connection_.use(had - arrived.size());
    const bool has_room = held_.hold(bytes.size());
    const Clock::time_point deadline = body_deadline();
    if (state == HttpBody::State::too_large) {
      refuse_body({ErrorCode::too_large, "the body is too large", {}, exchange_->body_limit, {}});
    } else if (state == HttpBody::State::malformed) {
      refuse_body({InputCode::bad_syntax, "the chunks of the body do not parse", {}, {}, {}});
    } else if (!has_room || (state == HttpBody::State::complete && !held_.complete())) {
      refuse_body({ServiceCode::overloaded, "too many bodies are being received", {}, {}, {}});
    } else if (state == HttpBody::State::complete) {
      return go(Phase::reply);
    } else {
      // As for a head: what is there is read before time is judged. Whoever brings more than a
      // socket holds still sends.
      const bool late = overdue || Clock::now() > deadline;
      const std::size_t left = connection_.arrived().size();
      const Progress progress = connection_.receive(kBodyChunk);
      if (late) late_bytes += std::max(connection_.arrived().size() - left, kLeastPiece);
      if (progress == Progress::done && late_bytes <= kLateBytes) continue;
      if (progress == Progress::closed) {
        refuse_body(
            {ErrorCode::cancelled, "the client left before its body was complete", {}, {}, {}});
      } else if (late) {
        refuse_body({ServiceCode::request_timeout, "the body did not arrive in time", {}, {}, {}});
      } else {
        return wait_for(progress, deadline);
      }
    }
    return go(Phase::reply);
  }
}

void HttpConversation::release_reply() {
  if (!exchange_) return;
  const std::uint64_t bytes = std::exchange(exchange_->reply_charged, 0);
  if (bytes != 0) edge_.replies.give_back(exchange_->request.caller.client, bytes);
  exchange_->reply_reserved.reset();
}

void HttpConversation::refuse_body(Error error) {
  exchange_->refuse(std::move(error));
  exchange_->close = exchange_->body_unread = true;
  std::string().swap(exchange_->request.body);
  held_.release();
}

void HttpConversation::answer() {
  exchange_->body_bytes = exchange_->request.body.size();
  edge_.answer(*exchange_);
  std::string().swap(exchange_->request.body);
  held_.release();
  const HttpOptions& options = edge_.options;
  const Clock::time_point now = Clock::now();
  stalled_ = now + options.write_timeout;
  deadline_ = options.min_send_rate == 0
                  ? Clock::time_point::max()
                  : stalled_ + std::chrono::seconds(connection_.unsent() / options.min_send_rate);
  phase_ = Phase::sending;
}

auto HttpConversation::send_reply(bool overdue) -> MaybeNext {
  const std::uint64_t before = connection_.bytes_sent();
  const Progress progress = exchange_->failed || overdue ? Progress::closed : connection_.send();
  if (progress == Progress::wants_read || progress == Progress::wants_write) {
    const Clock::time_point now = Clock::now();
    if (connection_.bytes_sent() != before) stalled_ = now + edge_.options.write_timeout;
    const Clock::time_point deadline = std::min(stalled_, deadline_);
    if (now <= deadline) return wait_for(progress, deadline);
  }
  finish(progress == Progress::done);
  return {};
}

void HttpConversation::finish(bool sent) {
  const Clock::time_point now = Clock::now();
  const std::chrono::duration<double, std::milli> taken = now - exchange_->begin;
  ++edge_.requests;
  release_reply();
  log_request(exchange_->request, exchange_->route, exchange_->status,
              connection_.bytes_sent() - sent_before_, taken.count(), sent);
  edge_.options.finished({exchange_->request.method, exchange_->route, exchange_->status,
                          taken.count() / 1000, exchange_->body_bytes,
                          connection_.bytes_sent() - sent_before_});
  body_.reset();
  if (!sent) {
    phase_ = Phase::over;
  } else if (exchange_->close) {
    connection_.say_goodbye();
    deadline_ = now + kGoodbyeTime;
    pollfd query{connection_.socket(), POLLIN, 0};
    const bool listens = exchange_->body_unread || ::poll(&query, 1, 0) > 0;
    phase_ = listens ? Phase::goodbye : Phase::over;
  } else {
    exchange_.reset();
    deadline_ = now + edge_.keep_alive.load();
    phase_ = Phase::head;
  }
}

auto HttpConversation::part(bool overdue) -> MaybeNext {
  if (overdue || Clock::now() > deadline_) return go(Phase::over);
  if (connection_.discard(kGoodbyeChunk) == Progress::closed) return go(Phase::over);
  return Next{WaitsFor::readable, deadline_, false, true};
}

}  // namespace geodesic::server
