// Connections that begin with a PROXY header: who the client is, and who is let in.
#include <doctest/doctest.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/fixtures/test_seed.h"
#include "tests/server/edge/fixture.h"
#include "tests/server/proxies/announce.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

HttpOptions behind_proxies() {
  HttpOptions options = Edge::patient();
  options.trusted_proxies = *AddressRanges::parse("127.0.0.1,10.0.0.0/8");
  options.expects_proxy_header = true;
  return options;
}

std::string client_of(const Edge& edge, const std::string& begin, const std::string& headers = "") {
  RawClient client(edge.port);
  client.send(begin + get("/client", headers));
  return client.receive().body;
}

}  // namespace

TEST_CASE("the client is whom a trusted proxy announces, for all requests of the connection") {
  Edge edge(behind_proxies());
  CHECK(client_of(edge, announce("2001:db8:1:2:3::4", "::1")) == "2001:db8:1:2::/64");
  CHECK(client_of(edge, header_of(0x20, 0, "")) == "127.0.0.1");
  CHECK(client_of(edge, header_of(0x21, 0, std::string(20, '\0'))) == "127.0.0.1");
  RawClient client(edge.port);
  client.send(announce("198.51.100.7") + get("/seen") + get("/client"));
  CHECK(seen(client.receive())["remote"] == "198.51.100.7");
  CHECK(client.receive().body == "198.51.100.7");
  client.send(post("/echo", with_length("abc"), "abc"));
  CHECK(client.receive().body == "abc");
}

TEST_CASE("whom a proxy announces is believed in turn where it is a trusted proxy") {
  Edge edge(behind_proxies());
  const std::string far = "X-Forwarded-For: 203.0.113.9\r\n";
  CHECK(client_of(edge, announce("10.0.0.2"), far) == "203.0.113.9");
  CHECK(client_of(edge, announce("198.51.100.7"), far) == "198.51.100.7");
}

TEST_CASE("a header that comes byte by byte is read, and so is a request behind it") {
  Edge edge(behind_proxies());
  RawClient client(edge.port);
  for (const char byte : announce("198.51.100.7") + get("/client")) {
    REQUIRE(client.send(std::string(1, byte)));
  }
  CHECK(client.receive().body == "198.51.100.7");
}

TEST_CASE("who is no trusted proxy is closed at once, whatever it says") {
  Edge edge(behind_proxies());
  RawClient silent(edge.port, 2);
  CHECK(silent.ends());
  RawClient forger(edge.port, 2);
  forger.send(announce("198.51.100.7") + get("/client"));
  CHECK(forger.receive().status == 0);
  CHECK(client_of(edge, announce("198.51.100.7")) == "198.51.100.7");
  fixtures::wait_until([&] { return edge.server.stats().connections == 0; });
}

TEST_CASE("a trusted proxy that does not announce is closed without a reply") {
  Edge edge(behind_proxies());
  for (const std::string& begin :
       {std::string(), std::string("PROXY TCP4 198.51.100.7 192.0.2.1 54321 443\r\n"),
        std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11),
        header_of(0x21, 0x11, "short"), header_of(0x22, 0x11, std::string(12, '\0')),
        header_of(0x21, 0x12, std::string(12, '\0'))}) {
    CAPTURE(begin);
    RawClient client(edge.port);
    client.send(begin + get("/client"));
    CHECK(client.receive().status == 0);
  }
  CHECK(client_of(edge, announce("198.51.100.7")) == "198.51.100.7");
}

TEST_CASE("headers that do not end hold no thread, and are given up at the deadline of a head") {
  HttpOptions options = behind_proxies();
  options.io_threads = options.max_io_threads = 1;
  options.head_timeout = 2s;
  Edge edge(std::move(options));
  std::vector<std::unique_ptr<RawClient>> slow;
  for (std::size_t i = 0; i < 20; ++i) {
    slow.push_back(std::make_unique<RawClient>(edge.port));
    slow.back()->send(header_of(0x21, 0x11, std::string(65'535, 'x')).substr(0, i * i * i));
  }
  CHECK(client_of(edge, announce("198.51.100.7")) == "198.51.100.7");
  for (auto& one : slow) CHECK(one->receive().status == 0);
  CHECK(edge.server.stats().threads == 1);
}

TEST_CASE("random bytes before a request bring down nothing and are not answered") {
  std::mt19937 random(fixtures::test_seed());
  const auto below = [&](std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
  };
  Edge edge(behind_proxies());
  for (int draw = 0; draw < 200; ++draw) {
    std::string bytes = announce("198.51.100.7");
    const std::size_t at = below(14);  // of what the length and addresses do not change
    const char before = bytes[at];
    bytes[at] = static_cast<char>(below(256));
    const bool is_local = at == 12 && bytes[at] == '\x20';
    const bool is_good = bytes[at] == before || is_local || (at == 13 && bytes[at] == '\0');
    CAPTURE(at);
    RawClient client(edge.port);
    client.send(bytes + get("/client"));
    // A byte less than another family wants leaves the rest of the header missing; that is none
    // here.
    CHECK((client.receive().status == 200) == is_good);
  }
  CHECK(client_of(edge, announce("198.51.100.7")) == "198.51.100.7");
  fixtures::wait_until([&] { return edge.server.stats().connections == 0; });
}
