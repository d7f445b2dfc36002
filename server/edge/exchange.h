// One request on its way through the edge, and what its head says of it before a
// byte of the body is read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/edge/connection.h"
#include "server/edge/options.h"
#include "server/http/head.h"
#include "server/http/message.h"

namespace geodesic::server {

struct Exchange {
  explicit Exchange(HttpConnection& c) : connection(c) {}
  HttpConnection& connection;
  HttpHead head;
  std::optional<HeadError> refused;  // why the handler does not get to see it
  HttpRequest request;
  std::uint64_t body_limit = 0;
  std::uint64_t body_bytes = 0;  // received
  bool close = false;            // after the reply
  bool body_unread = false;      // bytes of it may still come
  HttpConnection::Clock::time_point begin = HttpConnection::Clock::now();

  // Of the reply.
  int status = 0;
  bool omit_length = false;                       // a reply that has no Content-Length, not even 0
  std::shared_ptr<const std::string> reply_body;  // follows the head; null: none, or streamed
  std::shared_ptr<const ReplyFile> reply_file;    // the same, where it is a file
  std::uint64_t reply_charged = 0;                // of the replies in flight
  std::shared_ptr<const void> reply_reserved;     // or counted by whoever made it
  bool streams = false;                           // its bytes are sent as they are made
  bool failed = false;                            // it could not be sent, or not all of it
  std::string route;

  void refuse(Error error, int status = 0) { refused = HeadError{std::move(error), status}; }
};

// Judges a head, or what came instead of one; `refused` says what is wrong.
// `peer` is the address that the connection comes from, or that a proxy has announced for it.
void judge_head(const HttpOptions& options, HttpConnection::Head outcome, std::string_view bytes,
                const std::string& peer, Exchange& exchange);

// What stands for the peer of that address in queues: itself, or its network in
// IPv6, where one subscriber has 2^64 addresses (a /64).
[[nodiscard]] std::string client_of(const std::string& address);

}  // namespace geodesic::server
