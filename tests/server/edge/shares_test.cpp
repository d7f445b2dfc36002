// One client that takes all it can get leaves enough for the others.
#include <doctest/doctest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "server/base/client_shares.h"
#include "server/base/service_codes.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/edge/fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::wait_until;

namespace {

using Clients = std::vector<std::unique_ptr<RawClient>>;

// How many of `count` connections from one address get their stream.
int streams_of(const Edge& edge, unsigned from, int count, Clients& clients) {
  int begun = 0;
  for (int i = 0; i < count; ++i) {
    clients.push_back(std::make_unique<RawClient>(edge.port, from));
    clients.back()->send(get("/endless"));
    char start[13] = {};
    REQUIRE(::recv(clients.back()->socket(), start, 12, MSG_WAITALL) == 12);
    const std::string status(start + 9);
    CHECK((status == "200" || status == "429" || status == "503"));
    begun += status == "200";
  }
  return begun;
}

}  // namespace

TEST_CASE("event streams of one client leave places for others") {
  HttpOptions options = Edge::patient();
  options.max_io_threads = 38;  // 20 streams
  Edge edge(std::move(options));
  Clients clients;
  CHECK(streams_of(edge, 1, 30, clients) == 10);
  CHECK(streams_of(edge, 2, 30, clients) == 5);
  CHECK(streams_of(edge, 3, 1, clients) == 1);
  RawClient refused(edge.port);
  refused.send(get("/endless"));
  const RawReply reply = refused.receive();
  CHECK(reply.status == 429);
  CHECK(reply.headers.count("retry-after") == 1);
  // Nothing is lost with those who leave.
  clients.clear();
  wait_until([&] { return edge.server.stats().connections <= 1; });
  CHECK(streams_of(edge, 1, 30, clients) == 10);
}

TEST_CASE("replies that one client does not take leave room for others', and small ones always") {
  HttpOptions options = Edge::patient();
  options.max_replies_in_flight = 100'000'000;
  Edge edge(std::move(options));
  Clients slow;
  for (int i = 0; i < 8; ++i) {
    slow.push_back(std::make_unique<RawClient>(edge.port, 2));
    slow.back()->send(get("/big"));
    char start[12];
    REQUIRE(::recv(slow.back()->socket(), start, sizeof start, MSG_PEEK | MSG_WAITALL) == 12);
  }
  RawClient other(edge.port, 3);
  other.send(get("/big"));
  CHECK(other.receive().body.size() == 20'000'000);
  for (unsigned from = 4; from < 8; ++from) {  // now it is full
    slow.push_back(std::make_unique<RawClient>(edge.port, from));
    slow.back()->send(get("/big"));
  }
  RawClient last(edge.port, 9);
  last.send(get("/x"));
  CHECK(last.receive().status == 200);
}

TEST_CASE("uploads that stall give way to those that come") {
  HttpOptions options = Edge::patient();
  options.max_bodies_in_flight = 4'500'000;
  options.receive_grace = 200ms;
  Edge edge(std::move(options));
  const std::string most(1'000'000, 'x');
  const std::string all(1'000'001, 'y');
  for (const unsigned from : {2U, 1U}) {  // for another client's, and for its own
    CAPTURE(from);
    Clients stalled;
    for (int i = 0; i < 4; ++i) {
      stalled.push_back(std::make_unique<RawClient>(edge.port));
      stalled.back()->send(post("/echo", with_length(all), most));
    }
    wait_until([&] { return edge.server.stats().body_bytes >= 4'000'000; });
    std::this_thread::sleep_for(2s);  // long enough to be known as slow
    for (int i = 0; i < 3; ++i) {
      RawClient coming(edge.port, from);
      coming.send(post("/echo", with_length(all), all));
      CHECK(coming.receive().body == all);
    }
    // One had to go, and was told so; the others can still be completed.
    int gone = 0;
    for (auto& client : stalled) {
      client->send("x");
      const RawReply reply = client->receive();
      CHECK((reply.status == 200 || reply.status == 503));
      if (reply.status == 503) CHECK(reply.headers.at("retry-after") == "1");
      gone += reply.status == 503;
    }
    CHECK(gone == 1);
    wait_until([&] { return edge.server.stats().body_bytes == 0; });
  }
}

TEST_CASE("shares halve what is left, and the first is served") {
  ClientShares shares(8, "things");
  for (int i = 0; i < 4; ++i) CHECK(shares.take("a", 1));
  CHECK(shares.take("a", 1).error().code == ServiceCode::too_many_requests);
  CHECK(shares.take("b", 1));
  CHECK(shares.take("b", 1));  // two of four that were left
  CHECK(shares.take("b", 1).error().code == ServiceCode::too_many_requests);
  CHECK(shares.take("c", 1));
  CHECK(shares.take("d", 1));
  CHECK(shares.take("e", 1).error().code == ServiceCode::overloaded);
  shares.give_back("a", 4);
  CHECK(shares.take("e", 1));
  for (const auto& [client, amount] : {std::pair{"b", 2}, {"c", 1}, {"d", 1}, {"e", 1}}) {
    shares.give_back(client, static_cast<std::uint64_t>(amount));
  }
  CHECK(shares.take("a", 100));  // alone, however much
  CHECK(shares.take("b", 1).error().code == ServiceCode::overloaded);
  CHECK(ClientShares(0, "things").take("a", 1000));
}
