// One request on its way through the edge, and the first of its three steps:
// the head is received and judged, before a byte of the body is read. (The
// other two, body and reply, are with cpp-httplib in http_server.cpp.)
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/http_connection.h"
#include "server/http_head.h"
#include "server/http_message.h"
#include "server/http_server.h"

namespace geodesic::server {

struct Exchange {
  explicit Exchange(HttpConnection& c) : connection(c) {}
  HttpConnection& connection;
  HttpHead head;
  std::optional<HeadError> refused;  // why the handler does not get to see it
  HttpRequest request;
  std::uint64_t body_limit = 0;
  bool close = false;        // after the reply
  bool body_unread = false;  // bytes of it may still come
  int status = 0;
  std::uint64_t reply_bytes = 0;
  bool omit_length = false;  // a reply that has no Content-Length, not even 0
  std::string route;
  std::uint64_t charged = 0;  // of the bodies in flight
  HttpConnection::Clock::time_point begin = HttpConnection::Clock::now();
};

// Reads and judges a head; `refused` says why, if it was. False: the peer left,
// there is nobody to answer.
[[nodiscard]] bool receive_head(const HttpOptions& options, Exchange& exchange);

}  // namespace geodesic::server
