// An HTTP edge for tests: a server whose handler answers with what it saw, and the
// requests that are sent to it as bytes.
#pragma once

#include <doctest/doctest.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "server/edge/server.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/edge/raw_client.h"

namespace geodesic::server::test {

using namespace std::chrono_literals;
using nlohmann::json;

// A line of the log per request would bury the test's own output.
inline const bool quiet = [] {
  spdlog::set_level(spdlog::level::off);
  return true;
}();

// A request for /held is answered once this is true.
inline std::atomic<bool> held_is_let_go{false};

// Answers with what it saw, so that tests can tell what reached a handler.
inline HttpResponse answer(HttpRequest& request) {
  HttpResponse response;
  if (request.path == "/throw") throw std::runtime_error("a secret of the inside");
  if (request.path == "/throw-number") throw 42;
  if (request.path == "/echo") {
    response.set_body(request.body, "application/octet-stream");
  } else if (request.path == "/big") {
    response.set_body(std::string(20'000'000, 'x'), "application/octet-stream");
  } else if (request.path == "/gone") {
    while (!request.caller()) std::this_thread::sleep_for(5ms);
    response.status = 499;
  } else if (request.path == "/held") {
    fixtures::wait_until([] { return held_is_let_go.load(); });
    response.set_body("held", "text/plain");
  } else if (request.path == "/empty") {
    response.status = 204;
  } else if (request.path == "/unchanged") {
    response.status = 304;
    response.set_header("ETag", "\"a\"");
  } else if (request.path == "/split") {
    response.set_header("X-Bad", "a\r\nSet-Cookie: stolen=1");
    response.set_body("x", "text/plain\r\nX-Evil: 1");
  } else if (request.path == "/stream") {
    response.content_type = "text/event-stream";
    response.stream = [n = 0](std::string& chunk) mutable {
      chunk = "data: " + std::to_string(n) + "\n\n";
      return n++ < 3;
    };
  } else if (request.path == "/large-chunk") {
    response.stream = [n = 0](std::string& chunk) mutable {
      chunk.assign(3'000'000, 'x');
      return n++ == 0;
    };
  } else if (request.path == "/half") {
    response.stream = [n = 0](std::string& chunk) mutable {
      if (n++ > 0) throw std::runtime_error("the rest cannot be made");
      chunk = "half";
      return true;
    };
  } else if (request.path == "/broken") {
    const auto broken = std::make_shared<std::optional<Error>>();
    response.broken = broken;
    response.stream = [n = 0, broken](std::string& chunk) mutable {
      chunk = "half";
      if (n++ == 0) return true;
      *broken = Error{ErrorCode::too_large, "the rest is too large", {}, {}, {}};
      return false;
    };
  } else if (request.path == "/endless") {
    response.content_type = "text/event-stream";
    response.stream = [gone = request.caller](std::string& chunk) {
      std::this_thread::sleep_for(5ms);
      chunk = ":\n\n";
      return !gone();
    };
  } else if (request.path.starts_with("/status/")) {
    response.status = std::stoi(request.path.substr(8));
    response.set_body("x", "text/plain");
  } else if (request.path == "/client") {
    response.set_body(request.caller.client, "text/plain");
  } else {
    json seen;
    seen["method"] = request.method;
    seen["path"] = request.path;
    seen["target"] = request.target;
    seen["query"] = request.query;
    seen["headers"] = request.headers;
    seen["body"] = request.body;
    seen["id"] = request.id;
    seen["remote"] = request.remote;
    response.set_body(seen.dump(-1, ' ', false, json::error_handler_t::replace),
                      "application/json");
  }
  return response;
}

struct Edge {
  explicit Edge(HttpOptions options = patient()) : server(std::move(options), answer) {
    const Result<int> bound = server.start();
    REQUIRE(bound);
    port = *bound;
  }
  static HttpOptions patient() {
    HttpOptions options;
    options.io_threads = 8;
    options.max_io_threads = 128;
    // So that no test depends on how busy the machine is; those on time set their own.
    options.keep_alive = options.head_timeout = options.body_timeout = 60s;
    options.write_timeout = options.receive_grace = 60s;
    options.min_receive_rate = options.min_send_rate = 0;
    options.max_body = [](std::string_view, std::string_view path) -> std::uint64_t {
      return path == "/echo" ? 2u << 20 : 1000;
    };
    return options;
  }
  HttpServer server;
  int port = 0;
};

inline constexpr std::string_view host = "Host: x\r\n";

inline std::string get(std::string_view target, std::string_view headers = "") {
  return "GET " + std::string(target) + " HTTP/1.1\r\n" + std::string(host) + std::string(headers) +
         "\r\n";
}

inline std::string post(std::string_view target, std::string_view headers, std::string_view body) {
  return "POST " + std::string(target) + " HTTP/1.1\r\n" + std::string(host) +
         std::string(headers) + "\r\n" + std::string(body);
}

inline std::string with_length(std::string_view body) {
  return "Content-Length: " + std::to_string(body.size()) + "\r\n";
}

// Sends bytes on a new connection; the reply must be a problem of that status
// and code, carry the fields every problem has, and end the connection.
inline json check_refused(const Edge& edge, const std::string& bytes, int status,
                          const std::string& code) {
  CAPTURE(bytes.substr(0, 200));
  RawClient client(edge.port);
  client.send(bytes);
  const RawReply reply = client.receive();
  CHECK(reply.status == status);
  CHECK(reply.headers.count("server") == 0);
  if (reply.status == 0) return {};
  CHECK(reply.headers.at("content-type") == "application/problem+json");
  CHECK(reply.headers.at("connection") == "close");
  const json problem = json::parse(reply.body, nullptr, false);
  REQUIRE(problem.is_object());
  CHECK(problem.value("status", 0) == status);
  CHECK(problem.value("code", "") == code);
  CHECK(problem.value("type", "") == "/docs/errors/#" + code);
  CHECK(problem.value("request_id", "") == reply.headers.at("x-request-id"));
  CHECK(!problem.value("title", "").empty());
  CHECK(!problem.value("detail", "").empty());
  CHECK(client.ends());
  return problem;
}

inline json seen(const RawReply& reply) {
  REQUIRE(reply.status == 200);
  return json::parse(reply.body);
}

}  // namespace geodesic::server::test
