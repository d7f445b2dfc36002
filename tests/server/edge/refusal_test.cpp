// The HTTP edge, attacked over raw sockets with bytes that are no request, or two.
#include <doctest/doctest.h>

#include "server/http/head.h"
#include "tests/server/edge/fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

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
           std::string("Content-Length:\t4\r\n"),
           std::string("Content-Length: 4\t\r\n"),
           std::string("Transfer-Encoding:\tchunked\r\n"),
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

TEST_CASE("a Host that names no host is refused, and so is an authority of a target") {
  Edge edge;
  for (const std::string host :
       {"",          "a b",     "a/b",      "u@h",    "u:p@h", "[::1",     "h:99999",    "h:65536",
        "h:abc",     "h:80:80", "h:-1",     "h:+1",   "h: 80", "<x>",      "a,b",        "a\\b",
        "a?b",       "a#b",     "%zz",      "%41",    "a;b",   "a\"b",     "h:80/",      "[]",
        "[::1]x",    "[h]",     "::1",      "[::1]:", "a..b",  ".a",       ".",          "..",
        "[::1%25a]", ":80",     "\xc3\xa9", "[v1.a]", "a\tb",  "http://h", "[::1]:99999"}) {
    if (host == "[::1]:") continue;  // the scheme's port, as "h:" is
    CHECK(check_refused(edge, "GET / HTTP/1.1\r\nHost: " + host + "\r\n\r\n", 400,
                        "bad_syntax")["parameter"] == "Host");
    if (host.find_first_of("/?# \t") != std::string::npos) continue;  // ends an authority
    check_refused(edge, get("http://" + host + "/"), 400, "bad_syntax");
  }
  check_refused(edge, get("http:///x"), 400, "bad_syntax");
  check_refused(edge, get("http://a_b/x"), 400, "bad_syntax");
  check_refused(edge, get("https://?x"), 400, "bad_syntax");
  for (const std::string host : {"h", "h:", "h:0", "h:65535", "127.0.0.1:80", "[::1]", "[::1]:8080",
                                 "a.b-c_d~e.", "[::ffff:1.2.3.4]"}) {
    CAPTURE(host);
    RawClient client(edge.port);
    client.send("GET /x HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    CHECK(client.receive().status == 200);
    if (host.find('_') != std::string::npos) continue;
    client.send(get("http://" + host + "/y"));
    CHECK(seen(client.receive())["path"] == "/y");
  }
}

TEST_CASE("no path is written in two ways") {
  Edge edge;
  for (const std::string target :
       {"/v1%2fmethods", "/v1%2Fmethods", "/%6detrics", "/%4Detrics", "/a%5cb", "/%2e%2e/a",
        "/a%7E", "/a%2D", "/a%5f", "/%30", "http://h/%6d", "/a%20%6d"}) {
    check_refused(edge, get(target), 400, "bad_syntax");
  }
  RawClient client(edge.port);
  client.send(get("/a%20b%C3%A9%3f?c=%6d%2f"));  // a query is no path
  const json request = seen(client.receive());
  CHECK(request["path"] == "/a b\u00e9?");
  CHECK(request["query"][0][1] == "m/");
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
