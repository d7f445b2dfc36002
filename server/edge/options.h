// What a listener is told: where it listens, and the bounds on what clients may
// do to it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "server/base/address_ranges.h"
#include "server/edge/tls.h"
#include "server/http/message.h"
#include "server/proxies/forwarded.h"

namespace geodesic::server {

// Those of the bounds below that may change while connections are served.
struct HttpPatience {
  std::chrono::milliseconds keep_alive;
  std::chrono::milliseconds body_timeout;
  std::uint64_t min_receive_rate;
};

// A request that was answered, or that was not for want of a client.
struct HttpFinished {
  std::string_view method;
  std::string_view route;  // see HttpResponse; may be empty
  int status;
  double seconds;  // from its head to the last byte of the reply
  std::uint64_t bytes_in;
  std::uint64_t bytes_out;
};

struct HttpOptions {
  // How a connection is taken from the listening socket (edge/listener.h); null: by accept4.
  std::function<int(int socket)> accept;
  // Told, by any thread, why no connection will be accepted any more, though nobody stopped
  // the server. Must not throw.
  std::function<void(const std::string& reason)> failed = [](const std::string&) {};
  std::string host = "127.0.0.1";   // a name or an address (IPv6 without brackets)
  int port = 0;                     // 0: any free one
  std::shared_ptr<TlsContext> tls;  // null: plain HTTP
  std::string base_path;            // of every request (HttpRequest::set_base_path)
  // Whose word on their clients is believed, and by which header (proxies/forwarded.h).
  AddressRanges trusted_proxies;
  ForwardedHeader forwarded_header = ForwardedHeader::x_forwarded_for;
  // Each connection begins with a header of the PROXY protocol (proxies/proxy_header.h), and comes
  // from a trusted proxy; others are closed.
  bool expects_proxy_header = false;

  // A thread is held by a request that is handled, and by nothing else.
  std::size_t io_threads = 64;               // started at once …
  std::size_t max_io_threads = 512;          // … and how many they may become
  std::size_t max_connections = 10'000;      // more push out who idles longest
  std::size_t keep_alive_count = 1'000'000;  // requests a connection

  // The most bytes a body may have.
  std::function<std::uint64_t(std::string_view method, std::string_view path)> max_body =
      [](std::string_view, std::string_view) { return std::uint64_t{8} << 20; };
  // Whether a request's body is worth receiving, by its head: if not, the handler is
  // called without it, and the connection closes after the reply. May tell the request's
  // caller which client's it is. May be asked by any thread; must not throw.
  std::function<bool(HttpRequest&)> wants_body = [](HttpRequest&) { return true; };
  // Told of every request at its end, by any thread. Must not throw.
  std::function<void(const HttpFinished&)> finished = [](const HttpFinished&) {};
  // Bytes of all bodies being received at once; for more, those that come the slowest are
  // answered 503 (edge/body_budget.h). 0: no bound.
  std::uint64_t max_bodies_in_flight = std::uint64_t{2} << 30;
  // Bytes of all replies that their clients have not taken yet; a further one becomes 503,
  // or 429 for who has his share (client_shares.h). Small ones are always sent. 0: no bound.
  std::uint64_t max_replies_in_flight = std::uint64_t{2} << 30;
  std::size_t max_target_bytes = 8192;     // of the raw path and query: 414
  std::size_t max_head_bytes = 32u << 10;  // of request line and headers: 431
  std::size_t max_header_count = 100;      // 431

  std::chrono::milliseconds keep_alive{75000};     // idle between requests
  std::chrono::milliseconds head_timeout{10000};   // from a head's first byte to its last: 408
  std::chrono::milliseconds body_timeout{300000};  // for an entire body, whatever the trickle: 408
  std::uint64_t min_receive_rate = 1u << 10;  // bytes a second of a body, on average: 408. 0: any …
  std::chrono::milliseconds receive_grace{5000};   // … once this is over
  std::chrono::milliseconds write_timeout{10000};  // no byte of a reply could be sent
  std::uint64_t min_send_rate = 16u << 10;  // bytes a second a client must take on average; 0: any
};

}  // namespace geodesic::server
