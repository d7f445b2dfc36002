// Clients that are idle, slow or gone, and a server that stops: what they may hold,
// and for how long.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <future>
#include <memory>
#include <thread>
#include <vector>

#include "tests/fixtures/wait_until.h"
#include "tests/server/edge/fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::is_soon;
using geodesic::fixtures::wait_until;

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
  HttpOptions options = Edge::patient();
  options.max_bodies_in_flight = 1'500'000;
  Edge edge(std::move(options));
  RawClient holder(edge.port);
  holder.send(post("/echo", "Content-Length: 1000001\r\n", std::string(1'000'000, 'x')));
  wait_until([&] { return edge.server.stats().body_bytes >= 1'000'000; });
  const std::string body(1'000'000, 'y');
  RawClient client(edge.port);
  client.send(post("/echo", with_length(body), body));
  const RawReply refused = client.receive();
  CHECK(refused.status == 503);
  CHECK(refused.headers.at("retry-after") == "1");
  holder.send("x");
  CHECK(holder.receive().status == 200);
  wait_until([&] { return edge.server.stats().body_bytes == 0; });
  RawClient again(edge.port);
  again.send(post("/echo", with_length(body), body));
  CHECK(again.receive().status == 200);
}

TEST_CASE("a body that trickles is given up at the deadline, however steadily it comes") {
  HttpOptions options = Edge::patient();
  options.body_timeout = 500ms;
  Edge edge(std::move(options));
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
}

TEST_CASE("a body that never pauses is given up at the deadline, too") {
  HttpOptions options = Edge::patient();
  options.body_timeout = 200ms;
  Edge edge(std::move(options));
  RawClient client(edge.port);
  client.send(post("/echo", "Transfer-Encoding: chunked\r\n", ""));
  std::string chunks;  // of one byte each, with much around it
  for (int i = 0; i < 100; ++i) chunks += "1;a=" + std::string(200, 'x') + "\r\nz\r\n";
  auto flood = std::async(std::launch::async, [&] {
    while (client.send(chunks)) {
    }
  });
  CHECK(client.receive().status == 408);
}

TEST_CASE("a head that trickles is given up at the deadline") {
  HttpOptions options = Edge::patient();
  options.head_timeout = 500ms;
  Edge edge(std::move(options));
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

TEST_CASE("what came in time is read, however late the server is") {
  constexpr auto kTimeout = 4s;  // no machine stands still for so long before the thread is taken
  HttpOptions options = Edge::patient();
  options.io_threads = options.max_io_threads = 1;
  options.head_timeout = options.body_timeout = kTimeout;
  Edge edge(std::move(options));
  RawClient body(edge.port);
  body.send(post("/echo", "Content-Length: 3\r\n", "a"));
  wait_until([&] { return edge.server.stats().body_bytes > 0; });
  RawClient head(edge.port);
  head.send("GET /x HTTP/1.1\r\n");
  {
    RawClient busy(edge.port);
    busy.send(get("/gone"));  // has the only thread until it leaves
    wait_until([&] { return edge.server.stats().running > 0; });
    body.send("bc");
    head.send("Host: x\r\n\r\n");
    std::this_thread::sleep_for(kTimeout + 200ms);
  }
  CHECK(body.receive().body == "abc");
  CHECK(head.receive().status == 200);
}

TEST_CASE("empty lines without end before a head hold no thread") {
  // Of one size a piece, or cut between the two bytes of a line's end.
  for (const std::size_t size : {std::size_t{1} << 16, (std::size_t{1} << 16) - 1}) {
    CAPTURE(size);
    HttpOptions options = Edge::patient();
    options.io_threads = options.max_io_threads = 1;
    options.keep_alive = options.head_timeout = 10s;  // ends what pauses now and then
    Edge edge(std::move(options));
    RawClient client(edge.port);
    std::string lines;
    while (lines.size() < (std::size_t{1} << 16)) lines += "\r\n";
    std::thread flood([&] {
      bool odd = false;
      while (client.send(std::string_view(lines).substr(odd ? 1 : 0, size)))
        odd = size % 2 != 0 && !odd;
    });
    flood.join();  // it was cut off
    RawClient other(edge.port);
    other.send(get("/x"));
    CHECK(other.receive().status == 200);
  }
}

TEST_CASE("an idle connection is closed without a word") {
  HttpOptions options = Edge::patient();
  options.keep_alive = 300ms;
  Edge edge(std::move(options));
  RawClient fresh(edge.port);
  CHECK(fresh.ends());
  RawClient used(edge.port);
  used.send(get("/x"));
  CHECK(used.receive().status == 200);
  CHECK(used.ends());
}

TEST_CASE("a handler learns that its client has hung up") {
  Edge edge;
  {
    RawClient client(edge.port);
    client.send(get("/gone"));
    wait_until([&] { return edge.server.stats().running != 0; });
  }
  CHECK(is_soon([&] { return edge.server.stats().running == 0; }, 5s));
}

TEST_CASE("a client that reads too slowly is given up") {
  HttpOptions options = Edge::patient();
  options.write_timeout = 300ms;
  Edge edge(std::move(options));
  RawClient client(edge.port);
  client.send(get("/big"));
  CHECK(is_soon([&] { return edge.server.stats().requests == 1; }, 5s));
}

TEST_CASE("draining lets running requests finish and refuses new connections") {
  Edge edge;
  RawClient running(edge.port);
  held_is_let_go = false;
  running.send(get("/held"));
  RawClient idle(edge.port);
  wait_until([&] { return edge.server.stats().running != 0; });
  auto stopped = std::async(std::launch::async, [&] { return edge.server.stop(5s); });
  CHECK(idle.ends());  // so the draining has begun
  held_is_let_go = true;
  const RawReply reply = running.receive();
  CHECK(reply.body == "held");
  CHECK(reply.headers.at("connection") == "close");
  CHECK(stopped.get());
  CHECK_THROWS(RawClient(edge.port));
  CHECK(edge.server.stop(1s));  // a second time does nothing
}

TEST_CASE("a large reply on its way is not truncated by draining") {
  Edge edge;
  RawClient client(edge.port);
  client.send(get("/big"));
  wait_until([&] { return edge.server.stats().connections != 0; });
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
  wait_until([&] { return edge.server.stats().running != 0; });
  CHECK_FALSE(edge.server.stop(100ms));
}

TEST_CASE("clients that idle or are slow in any way hold no thread") {
  HttpOptions options = Edge::patient();
  options.io_threads = options.max_io_threads = 1;
  Edge edge(std::move(options));
  std::vector<std::unique_ptr<RawClient>> slow;
  const auto connect = [&](std::string_view bytes) {
    slow.push_back(std::make_unique<RawClient>(edge.port));
    slow.back()->send(bytes);
  };
  const int each = 50;
  for (int i = 0; i < each; ++i) {
    connect("");
    connect(get("/used"));
    CHECK(slow.back()->receive().status == 200);
    connect("GET /head HTTP/1.1\r\nHost: x\r\n");
    connect(post("/echo", "Content-Length: 10\r\n", "12345"));
    connect(post("/echo", "Transfer-Encoding: chunked\r\n", "5\r\n123"));
    connect(get("/big"));  // and does not read
  }
  for (int round = 0; round < 3; ++round) {
    for (auto& client : slow) client->send("");
    RawClient fresh(edge.port);
    fresh.send(get("/new"));
    CHECK(seen(fresh.receive())["path"] == "/new");
  }
  CHECK(edge.server.stats().threads == 1);
  CHECK(edge.server.stats().connections >= slow.size());
  // Nor has any of them lost anything.
  for (std::size_t i = 0; i < slow.size(); i += 6) {
    slow[i]->send(get("/first"));
    CHECK(seen(slow[i]->receive())["path"] == "/first");
    slow[i + 1]->send(get("/second"));
    CHECK(seen(slow[i + 1]->receive())["path"] == "/second");
    slow[i + 2]->send("\r\n");
    CHECK(seen(slow[i + 2]->receive())["path"] == "/head");
    slow[i + 3]->send("67890");
    CHECK(slow[i + 3]->receive().body == "1234567890");
    slow[i + 4]->send("45\r\n0\r\n\r\n");
    CHECK(slow[i + 4]->receive().body == "12345");
  }
  CHECK(slow[5]->receive().body == std::string(20'000'000, 'x'));
  CHECK(slow.back()->receive().body == std::string(20'000'000, 'x'));
}

TEST_CASE("a body slower than the least rate is given up long before the deadline") {
  HttpOptions options = Edge::patient();
  options.body_timeout = 600s;
  options.min_receive_rate = 100'000;
  options.receive_grace = 200ms;
  Edge edge(std::move(options));
  RawClient slow(edge.port);
  slow.send(post("/echo", "Content-Length: 2000000\r\n", "x"));
  RawClient steady(edge.port);
  const std::string body(1'000'000, 'y');
  steady.send(post("/echo", with_length(body), body.substr(0, 500'000)));
  CHECK(slow.receive().status == 408);
  CHECK(edge.server.stats().body_bytes == 500'000);  // has bought five seconds
  steady.send(body.substr(500'000));
  CHECK(steady.receive().body == body);
}

TEST_CASE("where no place is left, who idles longest makes room for who comes") {
  HttpOptions options = Edge::patient();
  options.max_connections = 8;
  Edge edge(std::move(options));
  std::vector<std::unique_ptr<RawClient>> idle;
  for (std::uint64_t i = 0; i < 11; ++i) {
    idle.push_back(std::make_unique<RawClient>(edge.port));
    idle.back()->send(get("/x"));
    CHECK(idle.back()->receive().status == 200);
    // A client may have its reply before its connection counts as idle.
    const std::uint64_t waiting = std::min<std::uint64_t>(i + 1, 8);
    wait_until([&] { return edge.server.stats().dispensable >= waiting; });
  }
  wait_until([&] { return edge.server.stats().connections <= 8; });
  int left = 0;
  for (std::size_t i = 0; i < idle.size(); ++i) {
    idle[i]->send(get("/still-here"));
    const bool served = idle[i]->receive().status == 200;
    left += served;
    if (i >= 8) CHECK(served);
  }
  CHECK(left == 8);
}

TEST_CASE("where every place is held by a running request, who comes is turned away") {
  HttpOptions options = Edge::patient();
  options.max_connections = 2;
  Edge edge(std::move(options));
  {
    RawClient first(edge.port);
    RawClient second(edge.port);
    first.send(get("/gone"));
    second.send(get("/gone"));
    wait_until([&] { return edge.server.stats().running >= 2; });
    RawClient third(edge.port);
    third.send(get("/x"));
    CHECK(third.receive().status == 0);
  }
  wait_until([&] { return edge.server.stats().connections == 0; });
  RawClient fourth(edge.port);
  fourth.send(get("/x"));
  CHECK(fourth.receive().status == 200);
}

TEST_CASE("requests that block are joined by more threads, up to the bound") {
  HttpOptions options = Edge::patient();
  options.io_threads = 1;
  options.max_io_threads = 20;
  Edge edge(std::move(options));
  std::vector<std::unique_ptr<RawClient>> blocked;
  for (std::uint64_t i = 0; i < 19; ++i) {
    blocked.push_back(std::make_unique<RawClient>(edge.port));
    blocked.back()->send(get("/gone"));
    wait_until([&] { return edge.server.stats().running > i; });
    RawClient fresh(edge.port);
    fresh.send(get("/new"));
    CHECK(fresh.receive().status == 200);
  }
  CHECK(edge.server.stats().threads <= 20);
}

TEST_CASE("streamed replies, which hold threads, are bounded") {
  HttpOptions options = Edge::patient();
  options.io_threads = 2;
  options.max_io_threads = 6;
  Edge edge(std::move(options));
  std::vector<std::unique_ptr<RawClient>> listeners;
  for (unsigned i = 0; i < 4; ++i) {  // of several clients: one gets no more than half
    listeners.push_back(std::make_unique<RawClient>(edge.port, 1 + i));
    listeners.back()->send(get("/endless"));
    char byte;
    CHECK(::recv(listeners.back()->socket(), &byte, 1, 0) == 1);
  }
  RawClient fifth(edge.port, 5);
  fifth.send(get("/endless"));
  const RawReply refused = fifth.receive();
  CHECK(refused.status == 503);
  CHECK(refused.headers.at("retry-after") == "1");
  fifth.send(get("/x"));
  CHECK(fifth.receive().status == 200);
  listeners.clear();
  // Their places are free once the server has noticed.
  for (int attempt = 0; attempt < 1000; ++attempt) {
    fifth.send("HEAD /x HTTP/1.1\r\nHost: x\r\n\r\n");
    CHECK(fifth.receive(true).status == 200);
    if (edge.server.stats().running == 0 && edge.server.stats().connections == 1) break;
    std::this_thread::sleep_for(5ms);
  }
  RawClient sixth(edge.port);
  sixth.send(get("/endless"));
  char start[12];
  REQUIRE(::recv(sixth.socket(), start, sizeof start, MSG_WAITALL) == sizeof start);
  CHECK(std::string(start, sizeof start) == "HTTP/1.1 200");
}

TEST_CASE("draining ends idle connections at once and waits for a request half sent") {
  HttpOptions options = Edge::patient();
  Edge edge(std::move(options));
  RawClient idle(edge.port);
  idle.send(get("/x"));
  CHECK(idle.receive().status == 200);
  RawClient half(edge.port);
  half.send(post("/echo", "Content-Length: 4\r\n", "ab"));
  wait_until([&] { return edge.server.stats().body_bytes == 2; });
  auto stopped = std::async(std::launch::async, [&] { return edge.server.stop(10s); });
  CHECK(idle.ends());
  half.send("cd");
  const RawReply reply = half.receive();
  CHECK(reply.body == "abcd");
  CHECK(reply.headers.at("connection") == "close");
  CHECK(stopped.get());
}

TEST_CASE("replies that nobody takes have a limit together") {
  HttpOptions options = Edge::patient();
  options.max_replies_in_flight = 50'000'000;
  Edge edge(std::move(options));
  std::vector<std::unique_ptr<RawClient>> slow;
  for (unsigned i = 0; i < 2; ++i) {
    slow.push_back(std::make_unique<RawClient>(edge.port, 2 + i));
    slow.back()->send(get("/big"));
    // Its head is there, but most of its body waits.
    char start[12];
    REQUIRE(::recv(slow.back()->socket(), start, sizeof start, MSG_PEEK | MSG_WAITALL) == 12);
  }
  RawClient client(edge.port);
  client.send(get("/big"));
  const RawReply refused = client.receive();
  CHECK(refused.status == 503);
  CHECK(refused.headers.at("retry-after") == "1");
  client.send(get("/small"));
  CHECK(client.receive().status == 200);
  CHECK(slow[0]->receive().body.size() == 20'000'000);
  CHECK(slow[1]->receive().body.size() == 20'000'000);
  wait_until([&] { return edge.server.stats().requests >= 4; });
  client.send(get("/big"));
  CHECK(client.receive().body.size() == 20'000'000);
}
