#include "server/http_exchange.h"

#include "server/request_log.h"

namespace geodesic::server {

namespace {

// Refuses a body by what the head says of it, before any of it is read.
void judge_body(const HttpOptions& options, Exchange& exchange) {
  const HttpHead& head = exchange.head;
  if (!head.chunked && head.body_bytes == 0) return;
  const std::string* const coding = head.header("Content-Encoding");
  if (coding != nullptr && !coding->empty() && !equals_ignoring_case(*coding, "identity")) {
    exchange.refused = HeadError{
        Error{ErrorCode::unsupported, "bodies must not be compressed", "Content-Encoding", {}, {}},
        415};
    return;
  }
  exchange.body_limit = options.max_body(exchange.request.method, exchange.request.path);
  if (head.body_bytes > exchange.body_limit) {
    exchange.refused = HeadError{Error{
        ErrorCode::too_large, "the body is too large", {}, exchange.body_limit, head.body_bytes}};
  }
}

}  // namespace

bool receive_head(const HttpOptions& options, Exchange& exchange) {
  std::string bytes;
  const auto outcome =
      exchange.connection.read_head(options.max_target_bytes, options.max_head_bytes,
                                    HttpConnection::Clock::now() + options.head_timeout, bytes);
  exchange.begin = HttpConnection::Clock::now();
  const HeadLimits limits{options.max_target_bytes, options.max_header_count};
  exchange.refused = parse_head(bytes, limits, exchange.head);
  const auto refuse = [&](ErrorCode code, const char* detail, int status,
                          std::optional<std::uint64_t> limit = {}) {
    exchange.refused = HeadError{Error{code, detail, {}, limit, {}}, status};
  };
  switch (outcome) {
    case HttpConnection::Head::complete:
      break;
    case HttpConnection::Head::closed:
      return false;
    case HttpConnection::Head::timed_out:
      refuse(ErrorCode::request_timeout, "the request's head did not arrive in time", 0);
      break;
    case HttpConnection::Head::target_too_long:
      refuse(ErrorCode::too_large, "the request target is too long", 414, options.max_target_bytes);
      break;
    case HttpConnection::Head::too_long:
      refuse(ErrorCode::too_large, "the request's headers are too long", 431,
             options.max_head_bytes);
      break;
  }

  HttpHead& head = exchange.head;
  HttpRequest& request = exchange.request;
  const std::string* const id = head.header("X-Request-Id");
  request.id = id != nullptr && is_sane_request_id(*id) ? *id : make_request_id();
  request.method = head.method;
  request.target = head.target;
  request.path = std::move(head.path);
  request.query = std::move(head.query);
  request.client_gone = [watch = exchange.connection.watch()] { return watch->gone(); };
  if (!exchange.refused) judge_body(options, exchange);
  request.headers = std::move(head.headers);
  // Whatever a refused request sent next is not a request.
  exchange.body_unread = exchange.refused.has_value();
  return true;
}

}  // namespace geodesic::server
