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
// Threads: a connection holds one I/O thread for as long as it lives. So there
// are many, keep-alive is short, and connections that idle are closed when
// others wait for a thread. Handlers run on I/O threads; heavy work belongs in
// the compute pool.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "server/http_message.h"

namespace geodesic::server {

using HttpHandler = std::function<HttpResponse(HttpRequest&)>;

struct HttpOptions {
  std::string host = "127.0.0.1";  // a name or an address (IPv6 without brackets)
  int port = 0;                    // 0: any free one

  std::size_t io_threads = 64;          // started at once …
  std::size_t max_io_threads = 512;     // … and how many they may become
  std::size_t max_waiting = 1024;       // accepted connections without a thread; more are closed
  std::size_t keep_alive_count = 1000;  // requests a connection

  // The most bytes a body may have.
  std::function<std::uint64_t(std::string_view method, std::string_view path)> max_body =
      [](std::string_view, std::string_view) { return std::uint64_t{8} << 20; };
  // Bytes of all bodies being received at once; more are answered 503. 0: no bound.
  std::uint64_t max_bodies_in_flight = std::uint64_t{2} << 30;
  std::size_t max_target_bytes = 8192;     // of the raw path and query: 414
  std::size_t max_head_bytes = 32u << 10;  // of request line and headers: 431
  std::size_t max_header_count = 100;      // 431

  std::chrono::milliseconds keep_alive{5000};      // idle between requests
  std::chrono::milliseconds head_timeout{10000};   // from a head's first byte to its last: 408
  std::chrono::milliseconds body_timeout{60000};   // for an entire body, whatever the trickle: 408
  std::chrono::milliseconds write_timeout{10000};  // no byte of a reply could be sent
  std::uint64_t min_send_rate = 16u << 10;  // bytes a second a client must take on average; 0: any
};

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

  struct Stats {
    std::uint64_t connections = 0;  // open now, those without a thread included
    std::uint64_t waiting = 0;      // accepted, but without a thread
    std::uint64_t running = 0;      // requests in the handler now
    std::uint64_t requests = 0;     // answered since the start
    std::uint64_t body_bytes = 0;   // of bodies being received or handled now
  };
  [[nodiscard]] Stats stats() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace geodesic::server
