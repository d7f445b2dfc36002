// The HTTP edge, attacked over raw sockets.
#include "server/http_server.h"

#include <doctest/doctest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <future>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>
#include <vector>

#include "server/http_head.h"
#include "server/problem.h"
#include "tests/server/raw_client.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using namespace std::chrono_literals;
using nlohmann::json;

namespace {

// A line of the log per request would bury the test's own output.
const bool quiet = [] {
  spdlog::set_level(spdlog::level::off);
  return true;
}();

// Answers with what it saw, so that tests can tell what reached a handler.
HttpResponse answer(HttpRequest& request) {
  HttpResponse response;
  if (request.path == "/throw") throw std::runtime_error("a secret of the inside");
  if (request.path == "/throw-number") throw 42;
  if (request.path == "/echo") {
    response.set_body(request.body, "application/octet-stream");
  } else if (request.path == "/big") {
    response.set_body(std::string(20'000'000, 'x'), "application/octet-stream");
  } else if (request.path == "/gone") {
    while (!request.client_gone()) std::this_thread::sleep_for(5ms);
    response.status = 499;
  } else if (request.path == "/sleep") {
    std::this_thread::sleep_for(300ms);
    response.set_body("slept", "text/plain");
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
  explicit Edge(HttpOptions options = quick()) : server(std::move(options), answer) {
    const Result<int> bound = server.start();
    REQUIRE(bound);
    port = *bound;
  }
  static HttpOptions quick() {
    HttpOptions options;
    options.io_threads = 8;
    options.max_io_threads = 128;
    options.keep_alive = 1000ms;
    options.head_timeout = 500ms;
    options.body_timeout = 500ms;
    options.max_body = [](std::string_view, std::string_view path) -> std::uint64_t {
      return path == "/echo" ? 2u << 20 : 1000;
    };
    return options;
  }
  HttpServer server;
  int port = 0;
};

constexpr std::string_view host = "Host: x\r\n";

std::string get(std::string_view target, std::string_view headers = "") {
  return "GET " + std::string(target) + " HTTP/1.1\r\n" + std::string(host) + std::string(headers) +
         "\r\n";
}

std::string post(std::string_view target, std::string_view headers, std::string_view body) {
  return "POST " + std::string(target) + " HTTP/1.1\r\n" + std::string(host) +
         std::string(headers) + "\r\n" + std::string(body);
}

std::string with_length(std::string_view body) {
  return "Content-Length: " + std::to_string(body.size()) + "\r\n";
}

// Sends bytes on a new connection; the reply must be a problem of that status
// and code, carry the fields every problem has, and end the connection.
json check_refused(const Edge& edge, const std::string& bytes, int status,
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
  CHECK(problem.value("type", "") == "/problems/" + code);
  CHECK(problem.value("request_id", "") == reply.headers.at("x-request-id"));
  CHECK(!problem.value("title", "").empty());
  CHECK(!problem.value("detail", "").empty());
  CHECK(client.ends());
  return problem;
}

json seen(const RawReply& reply) {
  REQUIRE(reply.status == 200);
  return json::parse(reply.body);
}

}  // namespace

TEST_CASE("a request arrives decoded, in order, with raw header values") {
  Edge edge;
  RawClient client(edge.port);
  client.send(get("/v1/a%20b/%C3%A9?from=v:1&x=a+b%2B&from=v:2&flag&=v", "X-Thing:  50%25 \r\n"));
  const RawReply reply = client.receive();
  const json request = seen(reply);
  CHECK(request["method"] == "GET");
  CHECK(request["path"] == "/v1/a b/\u00e9");
  CHECK(request["query"] ==
        json::parse(R"([["from","v:1"],["x","a b+"],["from","v:2"],["flag",""],["","v"]])"));
  CHECK(request["headers"] == json::parse(R"([["Host","x"],["X-Thing","50%25"]])"));
  CHECK(request["remote"] == "127.0.0.1");
  CHECK(request["id"] == reply.headers.at("x-request-id"));
  CHECK(reply.headers.at("date").size() == 29);
  CHECK(reply.headers.count("server") == 0);
  CHECK(reply.headers.count("accept-ranges") == 0);
}

TEST_CASE("a connection is used again, and pipelined requests are answered in order") {
  Edge edge;
  RawClient client(edge.port);
  for (int i = 0; i < 3; ++i) {
    client.send(get("/r" + std::to_string(i)));
    CHECK(seen(client.receive())["path"] == "/r" + std::to_string(i));
  }
  // Large enough that requests straddle every buffer's end.
  std::string pipeline;
  for (int i = 0; i < 200; ++i) {
    const std::string body(static_cast<std::size_t>(i * 37 % 900), 'b');
    pipeline += post("/p" + std::to_string(i), with_length(body), body);
  }
  std::thread writer([&] { client.send(pipeline); });
  for (int i = 0; i < 200; ++i) {
    const json request = seen(client.receive());
    CHECK(request["path"] == "/p" + std::to_string(i));
    CHECK(request["body"].get<std::string>().size() == static_cast<std::size_t>(i * 37 % 900));
  }
  writer.join();
}

TEST_CASE("every method reaches the handler, known or not") {
  Edge edge;
  RawClient client(edge.port);
  for (const std::string method :
       {"GET", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "FOO", "PROPFIND", "PRI"}) {
    client.send(method + " /m HTTP/1.1\r\nHost: x\r\nX-Request-Id: a.b-C_1\r\n\r\n");
    const RawReply reply = client.receive();
    CHECK(seen(reply)["method"] == method);
    CHECK(reply.headers.at("x-request-id") == "a.b-C_1");
  }
  client.send("OPTIONS * HTTP/1.1\r\nHost: x\r\n\r\n");
  CHECK(seen(client.receive())["path"] == "*");
  client.send("GET http://example.org:80/abs?a=1 HTTP/1.1\r\nHost: x\r\n\r\n");
  CHECK(seen(client.receive())["path"] == "/abs");
}

TEST_CASE("HEAD is GET without the body") {
  Edge edge;
  RawClient client(edge.port);
  client.send("HEAD /big HTTP/1.1\r\nHost: x\r\n\r\n");
  const RawReply reply = client.receive(/*is_head=*/true);
  CHECK(reply.status == 200);
  CHECK(reply.headers.at("content-length") == "20000000");
  CHECK(reply.headers.at("content-type") == "application/octet-stream");
  client.send("HEAD /stream HTTP/1.1\r\nHost: x\r\n\r\n");
  CHECK(client.receive(true).headers.count("content-length") == 0);
  client.send(get("/after"));
  CHECK(seen(client.receive())["path"] == "/after");
}

TEST_CASE("204 and 304 carry neither a body nor a length") {
  Edge edge;
  RawClient client(edge.port);
  for (const char* target : {"/empty", "/unchanged"}) {
    client.send(get(target));
    const RawReply reply = client.receive();
    CHECK(reply.headers.count("content-length") == 0);
    CHECK(reply.headers.count("content-type") == 0);
  }
  client.send(get("/after"));
  CHECK(seen(client.receive())["path"] == "/after");
}

TEST_CASE("a body arrives raw whatever its content type says") {
  Edge edge;
  const std::string form = "a=1&b=%00%ff+c";
  for (const std::string type :
       {"application/x-www-form-urlencoded", "multipart/form-data; boundary=x",
        "multipart/form-data", "application/json", "model/gltf-binary"}) {
    RawClient client(edge.port);
    client.send(post("/echo", "Content-Type: " + type + "\r\n" + with_length(form), form));
    CHECK(client.receive().body == form);
    client.send(post("/echo", "Content-Type: " + type + "\r\nTransfer-Encoding: chunked\r\n",
                     "3\r\na=1\r\nb;ext=1\r\n&b=%00%ff+c\r\n0\r\nTrailer: x\r\n\r\n"));
    CHECK(client.receive().body == form);
  }
}

TEST_CASE("a megabyte is echoed byte for byte, by length and by chunks") {
  Edge edge;
  std::string body(1u << 20, '\0');
  std::uint32_t state = 1;
  for (char& c : body) c = static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
  RawClient client(edge.port);
  client.send(post("/echo", with_length(body), body));
  CHECK(client.receive().body == body);
  std::string chunked;
  for (std::size_t at = 0; at < body.size(); at += 65536) {
    chunked += "10000\r\n" + body.substr(at, 65536) + "\r\n";
  }
  client.send(post("/echo", "Transfer-Encoding: chunked\r\n", chunked + "0\r\n\r\n"));
  CHECK(client.receive().body == body);
}

TEST_CASE("Expect: 100-continue is met before the body and not when it is refused") {
  Edge edge;
  RawClient client(edge.port);
  client.send(post("/echo", "Content-Length: 2\r\nExpect: 100-continue\r\n", ""));
  char line[25] = {};
  pollfd query{client.socket(), POLLIN, 0};
  REQUIRE(::poll(&query, 1, 2000) == 1);
  REQUIRE(::recv(client.socket(), line, sizeof line, MSG_WAITALL) == 25);
  CHECK(std::string(line, 25) == "HTTP/1.1 100 Continue\r\n\r\n");
  client.send("ok");
  CHECK(client.receive().body == "ok");
  check_refused(edge, post("/x", "Content-Length: 5000\r\nExpect: 100-continue\r\n", ""), 413,
                "too_large");
  check_refused(edge, post("/x", "Content-Length: 5\r\nExpect: magic\r\n", "12345"), 417,
                "unsupported");
}

TEST_CASE("no request can be smuggled in another") {
  Edge edge;
  const std::string inner = get("/smuggled");
  // Each is refused, and what follows it is never taken for a request.
  for (const std::string& headers : {
           std::string("Content-Length: 4\r\nTransfer-Encoding: chunked\r\n"),
           std::string("Content-Length: 0\r\nTransfer-Encoding: chunked\r\n"),
           std::string("Content-Length: 4\r\nContent-Length: 5\r\n"),
           std::string("Content-Length: 4\r\nContent-Length: 4\r\n"),
           std::string("Content-Length: 4, 4\r\n"),
           std::string("Content-Length: +4\r\n"),
           std::string("Content-Length: -4\r\n"),
           std::string("Content-Length: 0x4\r\n"),
           std::string("Content-Length: 4 4\r\n"),
           std::string("Content-Length: \r\n"),
           std::string("Content-Length: 99999999999999999999999\r\n"),
           std::string("Content-Length : 4\r\n"),
           std::string(" Content-Length: 4\r\n"),
           std::string("X: a\r\n Content-Length: 4\r\n"),
           std::string("X: a\nContent-Length: 4\r\n"),
           std::string("X: a\rContent-Length: 4\r\n"),
           std::string("X: a\0b\r\n", 8),
           std::string("X\0: a\r\n", 7),
           std::string("NoColon\r\n"),
           std::string(": empty name\r\n"),
           std::string("Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n"),
           std::string("Host: y\r\n"),
       }) {
    check_refused(edge, post("/outer", headers, "4\r\nabcd\r\n0\r\n\r\n" + inner), 400,
                  "bad_syntax");
  }
  for (const std::string coding : {"gzip, chunked", "chunked, chunked", "identity", "xchunked"}) {
    check_refused(edge,
                  post("/outer", "Transfer-Encoding: " + coding + "\r\n", "0\r\n\r\n" + inner), 501,
                  "unsupported");
  }
  check_refused(edge, "POST / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n" + inner, 400,
                "bad_syntax");
}

TEST_CASE("the body of a GET or HEAD is never taken for the next request") {
  Edge edge;
  const std::string inner = get("/smuggled");
  for (const std::string method : {"GET", "HEAD", "OPTIONS", "FOO"}) {
    CAPTURE(method);
    RawClient client(edge.port);
    client.send(method + " /outer HTTP/1.1\r\n" + std::string(host) + with_length(inner) + "\r\n" +
                inner + get("/next"));
    const RawReply first = client.receive(method == "HEAD");
    CHECK(first.status == 200);
    if (method != "HEAD") CHECK(seen(first)["body"] == inner);
    CHECK(seen(client.receive())["path"] == "/next");
  }
}

TEST_CASE("a POST or PUT without a length has an empty body") {
  Edge edge;
  for (const std::string method : {"POST", "PUT", "DELETE"}) {
    RawClient client(edge.port);
    client.send(method + " /none HTTP/1.1\r\nHost: x\r\n\r\n" + get("/next"));
    CHECK(seen(client.receive())["body"] == "");
    CHECK(seen(client.receive())["path"] == "/next");
  }
}

TEST_CASE("chunks that do not parse are refused") {
  Edge edge;
  for (const std::string chunks :
       {"zz\r\nabc\r\n0\r\n\r\n", "3\r\nabcd\r\n0\r\n\r\n", "\r\n\r\n", "3\r\nabc0\r\n\r\n"}) {
    check_refused(edge, post("/x", "Transfer-Encoding: chunked\r\n", chunks), 400, "bad_syntax");
  }
}

TEST_CASE("a body over the limit is refused, declared or not, and never buffered") {
  Edge edge;
  const json declared =
      check_refused(edge, post("/x", "Content-Length: 1001\r\n", ""), 413, "too_large");
  CHECK(declared["limit"] == 1000);
  CHECK(declared["actual"] == 1001);
  check_refused(edge, post("/x", "Content-Length: 18446744073709551615\r\n", "x"), 413,
                "too_large");
  const std::string chunk = "400\r\n" + std::string(1024, 'x') + "\r\n";
  const json chunked =
      check_refused(edge, post("/x", "Transfer-Encoding: chunked\r\n", chunk + chunk + "0\r\n\r\n"),
                    413, "too_large");
  CHECK(chunked["limit"] == 1000);
  check_refused(edge, post("/x", "Transfer-Encoding: chunked\r\n", "fffffffffffffff0\r\n" + chunk),
                413, "too_large");

  const std::string exact(1000, 'x');
  RawClient client(edge.port);
  client.send(post("/x", with_length(exact), exact));
  CHECK(seen(client.receive())["body"] == exact);
}

TEST_CASE("a client that pushes on after a 413 can still read it") {
  Edge edge;
  RawClient client(edge.port);
  client.send(post("/x", "Content-Length: 50000000\r\n", ""));
  const std::string block(100'000, 'x');
  for (int i = 0; i < 100 && client.send(block); ++i) {
  }
  CHECK(client.receive().status == 413);
}

TEST_CASE("all bodies together have a limit of their own") {
  HttpOptions options = Edge::quick();
  options.max_bodies_in_flight = 1'500'000;
  Edge edge(std::move(options));
  RawClient holder(edge.port);
  holder.send(post("/echo", "Content-Length: 1000001\r\n", std::string(1'000'000, 'x')));
  while (edge.server.stats().body_bytes < 1'000'000) std::this_thread::sleep_for(1ms);
  const std::string body(1'000'000, 'y');
  RawClient client(edge.port);
  client.send(post("/echo", with_length(body), body));
  const RawReply refused = client.receive();
  CHECK(refused.status == 503);
  CHECK(refused.headers.at("retry-after") == "1");
  holder.send("x");
  CHECK(holder.receive().status == 200);
  while (edge.server.stats().body_bytes != 0) std::this_thread::sleep_for(1ms);
  RawClient again(edge.port);
  again.send(post("/echo", with_length(body), body));
  CHECK(again.receive().status == 200);
}

TEST_CASE("compressed bodies are refused") {
  Edge edge;
  const json problem =
      check_refused(edge, post("/x", "Content-Encoding: gzip\r\nContent-Length: 3\r\n", "abc"), 415,
                    "unsupported");
  CHECK(problem["parameter"] == "Content-Encoding");
  RawClient client(edge.port);
  client.send(post("/x", "Content-Encoding: identity\r\nContent-Length: 3\r\n", "abc"));
  CHECK(seen(client.receive())["body"] == "abc");
}

TEST_CASE("a body that trickles is given up at the deadline, however steadily it comes") {
  Edge edge;
  const auto begin = std::chrono::steady_clock::now();
  RawClient client(edge.port);
  client.send(post("/x", "Content-Length: 900\r\n", ""));
  std::atomic<bool> stop{false};
  std::thread trickle([&] {
    while (!stop && client.send("x")) std::this_thread::sleep_for(20ms);
  });
  const RawReply reply = client.receive();
  stop = true;
  trickle.join();
  CHECK(reply.status == 408);
  CHECK(json::parse(reply.body)["code"] == "request_timeout");
  CHECK(std::chrono::steady_clock::now() - begin < 3s);
}

TEST_CASE("a head that trickles is given up at the deadline") {
  Edge edge;
  RawClient client(edge.port);
  client.send("GET /slow HTTP/1.1\r\nX-Request-Id: slow\r\n");
  std::atomic<bool> stop{false};
  std::thread trickle([&] {
    while (!stop && client.send("A: b\r\n")) std::this_thread::sleep_for(20ms);
  });
  const RawReply reply = client.receive();
  stop = true;
  trickle.join();
  CHECK(reply.status == 408);
}

TEST_CASE("an idle connection is closed without a word") {
  Edge edge;
  RawClient fresh(edge.port);
  CHECK(fresh.ends(4000ms));
  RawClient used(edge.port);
  used.send(get("/x"));
  CHECK(used.receive().status == 200);
  CHECK(used.ends(4000ms));
}

TEST_CASE("long targets, long heads and many headers are refused before they pile up") {
  Edge edge;
  const std::string at_limit = "/" + std::string(8191, 'a');
  RawClient client(edge.port);
  client.send(get(at_limit));
  CHECK(seen(client.receive())["target"] == at_limit);
  CHECK(check_refused(edge, get(at_limit + "a"), 414, "too_large")["limit"] == 8192);
  check_refused(edge, get("/" + std::string(1'000'000, 'a')), 414, "too_large");
  check_refused(edge, std::string(1'000'000, 'G'), 414, "too_large");
  std::string many;
  for (int i = 0; i < 101; ++i) many += "A: b\r\n";
  CHECK(check_refused(edge, get("/", many), 431, "too_large")["limit"] == 100);
  check_refused(edge, get("/", "A: " + std::string(1'000'000, 'b') + "\r\n"), 431, "too_large");
  std::string flood = "GET / HTTP/1.1\r\n";
  for (int i = 0; i < 200'000; ++i) flood += "A: b\r\n";
  check_refused(edge, flood, 431, "too_large");
}

TEST_CASE("targets that do not parse are refused") {
  Edge edge;
  for (const std::string target : {"/%", "/%4", "/%zz", "/a?b=%", "/a?b=%g0", "/a?%", "/%00",
                                   "/a?b=%00", "noslash", "*", "/a#b", "http://", ""}) {
    check_refused(edge, get(target), 400, "bad_syntax");
  }
  check_refused(edge, get("/a b"), 400, "bad_syntax");
  check_refused(edge, get(std::string("/a\0b", 4)), 400, "bad_syntax");
  check_refused(edge, get("/a\tb"), 400, "bad_syntax");
  CHECK(check_refused(edge, get("/a?from=%"), 400, "bad_syntax")["parameter"] == "from");

  RawClient client(edge.port);
  client.send(get("/\xc3\xa9\xff?n=\xe2\x82\xac"));  // raw bytes, not all of them UTF-8
  CHECK(seen(client.receive())["query"][0][1] == "\u20ac");
}

TEST_CASE("what is no HTTP/1 request is refused") {
  Edge edge;
  for (const std::string line :
       {"GET /", "GET", "GET  / HTTP/1.1", "GET / HTTP/x.1", "GET / http/1.1", "G@T / HTTP/1.1",
        "GET / HTTP/1.1 x", "GET / HTTP/11"}) {
    check_refused(edge, line + "\r\nHost: x\r\n\r\n", 400, "bad_syntax");
  }
  check_refused(edge, "GET / HTTP/1.1\r\n\r\n", 400, "bad_syntax");  // no Host
  check_refused(edge, "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 505, "unsupported");
  check_refused(edge, std::string("\x16\x03\x01\x02\x00\x01\x00", 7), 400, "bad_syntax");  // TLS
}

TEST_CASE("an insane request id is replaced and control characters never get out") {
  Edge edge;
  RawClient client(edge.port);
  for (const std::string id : {"a b", "", "<script>", "\xc3\xa9"}) {
    client.send(get("/x", "X-Request-Id: " + id + "\r\n"));
    const std::string made = client.receive().headers.at("x-request-id");
    CHECK(made != id);
    CHECK(made.size() == 16);
  }
  client.send(get("/x", "X-Request-Id: " + std::string(65, 'a') + "\r\n"));
  CHECK(client.receive().headers.at("x-request-id").size() == 16);
  client.send(get("/split"));
  const RawReply reply = client.receive();
  CHECK(reply.headers.count("set-cookie") == 0);
  CHECK(reply.headers.count("x-evil") == 0);
  CHECK(reply.headers.at("x-bad") == "aSet-Cookie: stolen=1");
}

TEST_CASE("what a handler throws becomes a 500 without details, and the connection lives on") {
  Edge edge;
  RawClient client(edge.port);
  for (const char* target : {"/throw", "/throw-number"}) {
    client.send(get(target));
    const RawReply reply = client.receive();
    CHECK(reply.status == 500);
    CHECK(json::parse(reply.body)["code"] == "internal");
    CHECK(reply.body.find("secret") == std::string::npos);
  }
  client.send(get("/after"));
  CHECK(seen(client.receive())["path"] == "/after");
}

TEST_CASE("a log line holds one request and nothing can break out of it") {
  std::ostringstream lines;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(lines)));
  {
    Edge edge;
    RawClient client(edge.port);
    client.send(get("/a\"\xff" + std::string(500, 'b'), "X-Request-Id: the-id\r\n"));
    CHECK(client.receive().status == 200);
    edge.server.stop(1s);
  }
  spdlog::set_default_logger(before);
  const std::string log = lines.str();
  CHECK(std::count(log.begin(), log.end(), '\n') == 1);
  CHECK(log.find(" the-id 127.0.0.1 GET /a\\x22\\xffbbb") != std::string::npos);
  CHECK(log.find("bbb... 200 ") != std::string::npos);
  CHECK(log.size() < 400);
}

TEST_CASE("HTTP/1.0 and Connection: close end the connection after the reply") {
  Edge edge;
  for (const std::string& bytes :
       {std::string("GET /x HTTP/1.0\r\n\r\n"), get("/x", "Connection: close\r\n"),
        get("/x", "Connection: foo, Close\r\n")}) {
    RawClient client(edge.port);
    client.send(bytes);
    const RawReply reply = client.receive();
    CHECK(reply.status == 200);
    CHECK(reply.headers.at("connection") == "close");
    CHECK(client.ends());
  }
}

TEST_CASE("a reply can be streamed") {
  Edge edge;
  RawClient client(edge.port);
  client.send(get("/stream"));
  CHECK(client.receive().body == "data: 0\n\ndata: 1\n\ndata: 2\n\n");
  client.send(get("/after"));
  CHECK(client.receive().status == 200);
  RawClient old(edge.port);
  old.send("GET /stream HTTP/1.0\r\n\r\n");
  CHECK(old.receive().body == "data: 0\n\ndata: 1\n\ndata: 2\n\n");
}

TEST_CASE("64 clients at once all get their own answers") {
  Edge edge;
  std::vector<std::future<int>> clients;
  for (int c = 0; c < 64; ++c) {
    clients.push_back(std::async(std::launch::async, [&edge, c] {
      int right = 0;
      auto client = std::make_unique<RawClient>(edge.port);
      for (int i = 0; i < 20; ++i) {
        const std::string body = std::to_string(c) + ":" + std::to_string(i);
        client->send(post("/echo", with_length(body), body));
        const RawReply reply = client->receive();
        right += reply.body == body;
        // Under pressure the server may ask for a new connection.
        if (reply.headers.count("connection")) client = std::make_unique<RawClient>(edge.port);
      }
      return right;
    }));
  }
  for (auto& client : clients) CHECK(client.get() == 20);
  edge.server.stop(5s);  // a request counts once its reply has been sent
  CHECK(edge.server.stats().requests == 64 * 20);
}

TEST_CASE("idle connections do not starve new clients") {
  HttpOptions options = Edge::quick();
  options.io_threads = 2;
  options.max_io_threads = 2;
  options.keep_alive = 30s;
  Edge edge(std::move(options));
  std::vector<std::unique_ptr<RawClient>> idle;
  for (int i = 0; i < 2; ++i) {
    idle.push_back(std::make_unique<RawClient>(edge.port));
    idle.back()->send(get("/x"));
    CHECK(idle.back()->receive().status == 200);
  }
  const auto begin = std::chrono::steady_clock::now();
  RawClient client(edge.port);
  client.send(get("/new"));
  CHECK(client.receive().status == 200);
  CHECK(std::chrono::steady_clock::now() - begin < 3s);
}

TEST_CASE("a handler learns that its client has hung up") {
  Edge edge;
  {
    RawClient client(edge.port);
    client.send(get("/gone"));
    while (edge.server.stats().running == 0) std::this_thread::sleep_for(1ms);
  }
  const auto begin = std::chrono::steady_clock::now();
  while (edge.server.stats().running != 0 && std::chrono::steady_clock::now() - begin < 5s) {
    std::this_thread::sleep_for(1ms);
  }
  CHECK(edge.server.stats().running == 0);
}

TEST_CASE("a client that reads too slowly is given up") {
  HttpOptions options = Edge::quick();
  options.write_timeout = 300ms;
  Edge edge(std::move(options));
  RawClient client(edge.port);
  client.send(get("/big"));
  const auto begin = std::chrono::steady_clock::now();
  while (edge.server.stats().requests == 0 && std::chrono::steady_clock::now() - begin < 5s) {
    std::this_thread::sleep_for(5ms);
  }
  CHECK(edge.server.stats().requests == 1);
}

TEST_CASE("draining lets running requests finish and refuses new connections") {
  Edge edge;
  RawClient running(edge.port);
  running.send(get("/sleep"));
  RawClient idle(edge.port);
  while (edge.server.stats().running == 0) std::this_thread::sleep_for(1ms);
  auto stopped = std::async(std::launch::async, [&] { return edge.server.stop(5s); });
  const RawReply reply = running.receive();
  CHECK(reply.body == "slept");
  CHECK(reply.headers.at("connection") == "close");
  CHECK(idle.ends());
  CHECK(stopped.get());
  CHECK_THROWS(RawClient(edge.port));
  CHECK(edge.server.stop(1s));  // a second time does nothing
}

TEST_CASE("a large reply on its way is not truncated by draining") {
  Edge edge;
  RawClient client(edge.port);
  client.send(get("/big"));
  while (edge.server.stats().connections == 0) std::this_thread::sleep_for(1ms);
  std::this_thread::sleep_for(50ms);  // the handler has long answered; the socket's buffer is full
  auto stopped = std::async(std::launch::async, [&] { return edge.server.stop(10s); });
  std::this_thread::sleep_for(50ms);
  CHECK(client.receive().body.size() == 20'000'000);
  CHECK(stopped.get());
}

TEST_CASE("draining cuts what outlives the grace") {
  Edge edge;
  RawClient client(edge.port);
  client.send(get("/gone"));
  while (edge.server.stats().running == 0) std::this_thread::sleep_for(1ms);
  const auto begin = std::chrono::steady_clock::now();
  CHECK_FALSE(edge.server.stop(100ms));
  CHECK(std::chrono::steady_clock::now() - begin < 3s);
}

TEST_CASE("a port in use is an error that says so") {
  Edge edge;
  HttpOptions options;
  options.port = edge.port;
  HttpServer second(options, answer);
  const Result<int> bound = second.start();
  REQUIRE_FALSE(bound);
  CHECK(bound.error().detail.find("Address already in use") != std::string::npos);
  CHECK(bound.error().detail.find(std::to_string(edge.port)) != std::string::npos);
  options.host = "name.invalid";
  HttpServer third(options, answer);
  CHECK_FALSE(third.start());
}

TEST_CASE("the head parser takes any bytes without harm") {
  std::uint32_t state = 7;
  const auto random = [&] { return (state = state * 1664525u + 1013904223u) >> 8; };
  const std::string valid = get("/a%20b?c=d&e", "Content-Length: 5\r\nX-Y: z\r\n");
  int accepted = 0;
  for (int i = 0; i < 100'000; ++i) {
    std::string bytes = valid;
    for (std::uint32_t changes = random() % 4; changes > 0; --changes) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    HttpHead head;
    if (parse_head(bytes, HeadLimits{100, 10}, head)) continue;
    ++accepted;
    CHECK((head.path == "*" || head.path.front() == '/'));
    CHECK(head.path.find('\0') == std::string::npos);
  }
  CHECK(accepted > 1000);
}

TEST_CASE("every error code has a status, a title and a problem that parses") {
  for (int i = 0; i <= static_cast<int>(ErrorCode::internal); ++i) {
    const auto code = static_cast<ErrorCode>(i);
    CAPTURE(name_of(code));
    CHECK(http_status(code) >= 400);
    CHECK(http_status(code) < 600);
    CHECK((http_status(code) == 503) == (retry_after_seconds(code) > 0));
    const json problem =
        json::parse(to_problem_json(Error{code, "\xff", "from[2]", 5, 6}, "/x\xff", "id"));
    CHECK(problem["type"] == "/problems/" + std::string(name_of(code)));
    CHECK(problem["title"] == problem_title(code));
    CHECK(problem["status"] == http_status(code));
    CHECK(problem["parameter"] == "from[2]");
    CHECK(problem["limit"] == 5);
    CHECK(problem["actual"] == 6);
    CHECK(problem["instance"].get<std::string>().starts_with("/x"));
  }
  CHECK(http_status(ErrorCode::mesh_unknown) == 404);
  CHECK(http_status(ErrorCode::cancelled) == 499);
  CHECK(http_status(ErrorCode::deadline) == 504);
  CHECK(http_status(ErrorCode::method_unknown) == 422);
}
