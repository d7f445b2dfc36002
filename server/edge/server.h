// The HTTP edge: bytes of a socket to an `HttpRequest`, an `HttpResponse` back
// to bytes. One handler gets every request that is well formed, whatever its
// method and path; everything else is answered here, as problem+json. This is
// the only room that knows cpp-httplib, and no type of it leaves.
//
// What the edge promises to a handler:
//  - the body is complete, raw (no form or multipart parsing, no decoding) and
//    within the limit that `max_body` gave for this method and path;
//  - path and query are percent-decoded, hold no NUL, and came from one
//    unambiguous request head: no request can hide in the body of another;
//  - what the handler throws becomes a 500 without details, logged with the
//    request's id;
//  - HEAD is the handler's GET with the body left out: handlers need not care.
//
// Threads: one accepts. A connection whose client must act next (idle, or slow in
// its head, its body or in taking a reply) holds none; a request in the handler
// holds one. Handlers may block, as for a compute slot; heavy work belongs there.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

#include "core/base/error.h"
#include "server/edge/options.h"
#include "server/http/message.h"

namespace geodesic::server {

using HttpHandler = std::function<HttpResponse(HttpRequest&)>;

class HttpServer {
 public:
  HttpServer(HttpOptions options, HttpHandler handler);
  ~HttpServer();  // stops without grace if still running
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Binds, listens and serves on threads of its own. Returns the port. Fails
  // with `internal` and a sentence for the operator when the address cannot be
  // bound (in use, not ours, not resolvable). To be called once.
  [[nodiscard]] Result<int> start();

  // Drains: stops accepting at once, lets running requests finish (each reply
  // closes its connection), and cuts what is left after `grace`. Returns when
  // all threads have ended; true if nothing had to be cut. May be called from
  // any thread but a handler's; a second call does nothing.
  bool stop(std::chrono::milliseconds grace);

  // From now on each reply is the last of its connection, and says so: balancers that keep
  // connections let go of them before `stop` closes those that idle. Any thread.
  void close_after_replies();

  // Replaces those options: for bodies from now on, and for connections that begin to
  // idle from now on. Any thread.
  void set_patience(const HttpPatience& patience);

  // Replaces the option of that name, for replies from now on. Any thread.
  void set_max_replies_in_flight(std::uint64_t bytes);

  struct Stats {
    std::uint64_t connections = 0;      // open now
    std::uint64_t dispensable = 0;      // … that wait for their client, and can be pushed out
    std::uint64_t threads = 0;          // that serve them
    std::uint64_t running = 0;          // requests in the handler now
    std::uint64_t requests = 0;         // answered since the start
    std::uint64_t body_bytes = 0;       // of bodies being received or handled now
    std::uint64_t accept_failures = 0;  // attempts to accept a connection, since the start
    bool is_accepting = true;           // connections that wait can be taken
  };
  [[nodiscard]] Stats stats() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace geodesic::server
