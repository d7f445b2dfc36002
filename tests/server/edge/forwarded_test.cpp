// Who the client is, where proxies that are trusted say so.
#include "server/edge/forwarded.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/server/edge/fixture.h"

using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

std::string client(const std::vector<std::string>& headers, const std::string& peer = "10.0.0.1") {
  HttpHead head;
  for (const std::string& value : headers) {
    head.headers.emplace_back("x-forwarded-FOR", value);
    head.headers.emplace_back("X-Other", "198.51.100.9");
  }
  return forwarded_for(*AddressRanges::parse("10.0.0.0/8,fd00::/8"), head, peer);
}

}  // namespace

TEST_CASE("a proxy that nobody trusts says nothing of its client") {
  CHECK(client({"198.51.100.1"}, "203.0.113.5") == "203.0.113.5");
  CHECK(client({"10.0.0.7"}, "::1") == "::1");
  CHECK(client({}, "203.0.113.5") == "203.0.113.5");
}

TEST_CASE("the client is the last address that is no trusted proxy's") {
  CHECK(client({"198.51.100.1"}) == "198.51.100.1");
  CHECK(client({"198.51.100.1"}, "::ffff:10.0.0.1") == "198.51.100.1");
  CHECK(client({" 1.1.1.1 , 198.51.100.1\t,10.0.0.2,  fd00::7 "}) == "198.51.100.1");
  CHECK(client({"1.1.1.1", "198.51.100.1", "10.0.0.2"}) == "198.51.100.1");
  CHECK(client({"1.1.1.1, 10.0.0.2"}, "fd00::1") == "1.1.1.1");
  CHECK(client({"10.0.0.3,10.0.0.2"}) == "10.0.0.3");
}

TEST_CASE("brackets and ports are no part of an address") {
  CHECK(client({"198.51.100.1:49152"}) == "198.51.100.1");
  CHECK(client({"[2001:db8::1]:49152"}) == "2001:db8::1");
  CHECK(client({"[2001:db8::1]"}) == "2001:db8::1");
  CHECK(client({"2001:db8::1"}) == "2001:db8::1");
}

TEST_CASE("beyond what is no address, nothing is believed") {
  for (const std::string bad : {"", "unknown", "_hidden", "1.1.1", "[::1", "[]", "1.1.1.1\nX",
                                "a:b:c", "\"1.1.1.1\"", "1.1.1.1 2.2.2.2"}) {
    CAPTURE(bad);
    CHECK(client({"198.51.100.1," + bad}) == "10.0.0.1");
    CHECK(client({"198.51.100.1," + bad + ", 10.0.0.2"}) == "10.0.0.2");
  }
  CHECK(client({}) == "10.0.0.1");
  CHECK(client({","}) == "10.0.0.1");
}

TEST_CASE("a request through a trusted proxy is its client's") {
  HttpOptions options = Edge::patient();
  options.trusted_proxies = *AddressRanges::parse("127.0.0.1");
  Edge edge(std::move(options));
  RawClient raw(edge.port);
  const auto ask = [&](const std::string& target, const std::string& headers) {
    raw.send(get(target, headers));
    const RawReply reply = raw.receive();
    REQUIRE(reply.status == 200);
    return reply.body;
  };
  const std::string far = "X-Forwarded-For: 1.1.1.1, 2001:db8:1:2:3::4\r\n";
  CHECK(json::parse(ask("/seen", far))["remote"] == "2001:db8:1:2:3::4");
  CHECK(ask("/client", far) == "2001:db8:1:2::/64");
  CHECK(ask("/client", "X-Forwarded-For: 1.1.1.1\r\nX-Forwarded-For: 198.51.100.2\r\n") ==
        "198.51.100.2");
  CHECK(ask("/client", "") == "127.0.0.1");  // nothing is left of who asked last
}
