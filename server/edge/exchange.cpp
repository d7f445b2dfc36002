#include "server/edge/exchange.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <cstdint>

#include "server/base/service_codes.h"
#include "server/http/request_log.h"
#include "server/proxies/forwarded.h"

namespace geodesic::server {

namespace {

// Refuses a body by what the head says of it, before any of it is read.
void judge_body(const HttpOptions& options, Exchange& exchange) {
  const HttpHead& head = exchange.head;
  if (!head.chunked && head.body_bytes == 0) return;
  const std::string* const coding = head.header("Content-Encoding");
  if (coding != nullptr && !coding->empty() && !equals_ignoring_case(*coding, "identity")) {
    exchange.refuse(
        {ErrorCode::unsupported, "bodies must not be compressed", "Content-Encoding", {}, {}}, 415);
    return;
  }
  exchange.body_limit = options.max_body(exchange.request.method, exchange.request.path);
  if (head.body_bytes > exchange.body_limit) {
    exchange.refuse(
        {ErrorCode::too_large, "the body is too large", {}, exchange.body_limit, head.body_bytes});
  }
}

}  // namespace

void judge_head(const HttpOptions& options, HttpConnection::Head outcome, std::string_view bytes,
                const std::string& peer, Exchange& exchange) {
  exchange.begin = HttpConnection::Clock::now();
  const HeadLimits limits{options.max_target_bytes, options.max_header_count};
  exchange.refused = parse_head(bytes, limits, exchange.head);
  switch (outcome) {
    case HttpConnection::Head::complete:
      break;
    case HttpConnection::Head::incomplete:
      exchange.refuse(
          {ServiceCode::request_timeout, "the request's head did not arrive in time", {}, {}, {}});
      break;
    case HttpConnection::Head::target_too_long:
      exchange.refuse({ErrorCode::too_large,
                       "the request target is too long; POST takes the parameters in its body",
                       {},
                       options.max_target_bytes,
                       {}},
                      414);
      break;
    case HttpConnection::Head::too_long:
      exchange.refuse({ErrorCode::too_large,
                       "the request's headers are too long",
                       {},
                       options.max_head_bytes,
                       {}},
                      431);
      break;
  }

  HttpHead& head = exchange.head;
  HttpRequest& request = exchange.request;
  const std::string* const id = head.header("X-Request-Id");
  request.id = id != nullptr && is_sane_request_id(*id) ? *id : make_request_id();
  request.method = head.method;
  request.target = head.target;
  request.path = std::move(head.path);
  request.set_base_path(options.base_path);
  request.authority = std::move(head.authority);
  request.query = std::move(head.query);
  request.remote = forwarded_for(options.trusted_proxies, options.forwarded_header, head, peer);
  request.caller.client = client_of(request.remote);
  request.caller.asked = std::make_shared<const Caller::Asked>(
      Caller::Asked{request.id, request.method, request.target});
  request.caller.gone = [watch = exchange.connection.watch()] { return watch->gone(); };
  if (!exchange.refused) judge_body(options, exchange);
  request.headers = std::move(head.headers);
  // Whatever a refused request sent next is not a request.
  exchange.body_unread = exchange.refused.has_value();
  exchange.close = exchange.refused || !head.keep_alive;
}

std::string client_of(const std::string& address) {
  in6_addr bytes{};
  const std::string bare = address.substr(0, address.find('%'));  // without the interface
  if (::inet_pton(AF_INET6, bare.c_str(), &bytes) != 1) return address;
  if (IN6_IS_ADDR_V4MAPPED(&bytes)) return address;
  std::fill(bytes.s6_addr + 8, bytes.s6_addr + 16, std::uint8_t{0});
  char text[INET6_ADDRSTRLEN];
  return ::inet_ntop(AF_INET6, &bytes, text, sizeof text) == nullptr ? address
                                                                     : std::string(text) + "/64";
}

}  // namespace geodesic::server
