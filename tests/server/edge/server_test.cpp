// What the HTTP edge promises to handlers and to well-behaved clients.
#include "server/edge/server.h"

#include <doctest/doctest.h>
#include <spdlog/sinks/ostream_sink.h>

#include <algorithm>
#include <future>
#include <memory>
#include <set>
#include <sstream>
#include <thread>
#include <vector>

#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"
#include "server/edge/exchange.h"
#include "server/http/problem.h"
#include "tests/server/edge/fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

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

TEST_CASE("a large chunk of a stream is sent in pieces, none copied whole") {
  Edge edge;
  RawClient client(edge.port);
  client.send(get("/large-chunk", "Connection: close\r\n"));
  const std::string all = client.receive_all();
  const std::size_t head = all.find("\r\n\r\n");
  REQUIRE(head != std::string::npos);
  std::size_t bytes = 0;
  for (std::size_t at = head + 4; at < all.size();) {
    const std::size_t size = std::stoul(all.substr(at, 16), nullptr, 16);
    CHECK(size <= 64u << 10);
    at = all.find("\r\n", at) + 2 + size + 2;
    bytes += size;
  }
  CHECK(bytes == 3'000'000);
}

TEST_CASE("a stream that throws ends its connection, and nothing else") {
  Edge edge;
  RawClient client(edge.port);
  client.send(get("/half"));
  const std::string all = client.receive_all();
  CHECK(all.find("half") != std::string::npos);
  CHECK_FALSE(all.ends_with("0\r\n\r\n"));  // which would say that it is complete
  RawClient other(edge.port);
  other.send(get("/after"));
  CHECK(other.receive().status == 200);
}

TEST_CASE("a stream that is broken off has no end that a client takes for one") {
  Edge edge;
  RawClient client(edge.port);
  client.send(get("/broken"));
  const std::string all = client.receive_all();
  CHECK(all.find("half") != std::string::npos);
  CHECK_FALSE(all.ends_with("0\r\n\r\n"));
  RawClient other(edge.port);
  other.send(get("/after"));
  CHECK(other.receive().status == 200);
}

TEST_CASE("64 clients at once all get their own answers") {
  Edge edge;
  std::vector<std::future<int>> clients;
  for (int c = 0; c < 64; ++c) {
    clients.push_back(std::async(std::launch::async, [&edge, c] {
      int right = 0;
      RawClient client(edge.port);
      for (int i = 0; i < 20; ++i) {
        const std::string body = std::to_string(c) + ":" + std::to_string(i);
        client.send(post("/echo", with_length(body), body));
        right += client.receive().body == body;
      }
      return right;
    }));
  }
  for (auto& client : clients) CHECK(client.get() == 20);
  edge.server.stop(5s);  // a request counts once its reply has been sent
  CHECK(edge.server.stats().requests == 64 * 20);
}

TEST_CASE("a client stands for itself in queues, and in IPv6 for its network") {
  Edge edge;
  RawClient client(edge.port);
  client.send(get("/client"));
  CHECK(client.receive().body == "127.0.0.1");
  CHECK(client_of("192.0.2.7") == "192.0.2.7");
  CHECK(client_of("::ffff:192.0.2.7") == "::ffff:192.0.2.7");
  CHECK(client_of("2001:db8:1:2:3:4:5:6") == "2001:db8:1:2::/64");
  CHECK(client_of("2001:db8:1:2::9") == client_of("2001:db8:1:2:ffff::1"));
  CHECK(client_of("fe80::1%eth0") == "fe80::/64");
  CHECK(client_of("").empty());
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

TEST_CASE("a status line says what its status means, and no other") {
  Edge edge;
  std::set<int> statuses{200, 201, 202, 204, 304};
  for (const ErrorCode code : all_error_codes()) statuses.insert(http_status(code));
  std::set<std::string> reasons;
  for (const int status : statuses) {
    RawClient client(edge.port);
    client.send(get("/status/" + std::to_string(status), "Connection: close\r\n"));
    const std::string reply = client.receive_all();
    const std::string line = reply.substr(0, reply.find("\r\n"));
    CAPTURE(line);
    CHECK(line.starts_with("HTTP/1.1 " + std::to_string(status) + " "));
    CHECK(reasons.insert(line.substr(line.find(' ', 9))).second);
    CHECK(reply.find("\r\nX-Request-Id: ") != std::string::npos);
  }
  // Whoever closes a half is told so too.
  RawClient client(edge.port);
  client.send(post("/echo", "Content-Length: 10\r\n", "abc"));
  client.half_close();
  CHECK(client.receive_all().starts_with("HTTP/1.1 499 Client Closed Request\r\n"));
}

TEST_CASE("a base path is taken off and refusals name it") {
  HttpOptions options = Edge::patient();
  options.base_path = "/geo";
  Edge edge(std::move(options));
  RawClient client(edge.port);
  client.send(get("/geo/a?b=c"));
  const json below = seen(client.receive());
  CHECK(below["path"] == "/a");
  CHECK(below["target"] == "/geo/a?b=c");
  client.send(get("/a"));
  CHECK(seen(client.receive())["path"] == "/a");
  client.send(get("/geology"));
  CHECK(seen(client.receive())["path"] == "/geology");
  // The bound on a body is that of the path without it.
  client.send(post("/geo/echo", with_length(std::string(5000, 'x')), std::string(5000, 'x')));
  CHECK(client.receive().status == 200);
  RawClient refused(edge.port);
  refused.send("GET /geo/a HTTP/1.1\r\n\r\n");  // without a host
  CHECK(refused.receive_all().find("\"type\":\"/geo/docs/errors/#bad_syntax\"") !=
        std::string::npos);
}

TEST_CASE("every error code has a status, a title and a problem that parses") {
  for (const ErrorCode code : all_error_codes()) {
    CAPTURE(code.name());
    CHECK(http_status(code) >= 400);
    CHECK(http_status(code) < 600);
    const bool later = http_status(code) == 503 || http_status(code) == 429;
    CHECK(later == (retry_after_seconds(code) > 0));
    HttpRequest request;
    request.target = "/x\xff";
    request.id = "id";
    const Error error{code, "\xff", "from[2]", 5, 6};
    const json problem = json::parse(to_problem_json(error, request));
    CHECK(problem["type"] == "/docs/errors/#" + std::string(code.name()));
    CHECK(problem["title"] == problem_title(code));
    CHECK(problem["status"] == http_status(code));
    CHECK(problem["parameter"] == "from[2]");
    CHECK(problem["limit"] == 5);
    CHECK(problem["actual"] == 6);
    CHECK(problem["instance"].get<std::string>().starts_with("/x"));
  }
  CHECK(http_status(ServiceCode::mesh_unknown) == 404);
  CHECK(http_status(ErrorCode::cancelled) == 499);
  CHECK(http_status(ServiceCode::deadline) == 504);
  CHECK(http_status(InputCode::method_unknown) == 422);
  CHECK(http_status(ServiceCode::too_many_requests) == 429);
}
