// Who the client is, where proxies that are trusted say so.
#include "server/proxies/forwarded.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/server/edge/fixture.h"

using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

std::string client_by(ForwardedHeader written, const std::vector<std::string>& headers,
                      const std::string& peer = "10.0.0.1") {
  const bool is_standard = written == ForwardedHeader::forwarded;
  HttpHead head;
  for (const std::string& value : headers) {
    head.headers.emplace_back(is_standard ? "forwardeD" : "x-forwarded-FOR", value);
    // What the proxies do not write, and let through.
    head.headers.emplace_back(is_standard ? "X-Forwarded-For" : "Forwarded",
                              is_standard ? "198.51.100.9" : "for=198.51.100.9");
  }
  return forwarded_for(*AddressRanges::parse("10.0.0.0/8,fd00::/8"), written, head, peer);
}

std::string client(const std::vector<std::string>& headers, const std::string& peer = "10.0.0.1") {
  return client_by(ForwardedHeader::x_forwarded_for, headers, peer);
}

std::string by_standard(const std::vector<std::string>& headers,
                        const std::string& peer = "10.0.0.1") {
  return client_by(ForwardedHeader::forwarded, headers, peer);
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

TEST_CASE("of Forwarded, the client is the last node that is no trusted proxy's") {
  CHECK(by_standard({"for=198.51.100.1"}) == "198.51.100.1");
  CHECK(by_standard({"for=198.51.100.1"}, "203.0.113.5") == "203.0.113.5");
  CHECK(by_standard({"FOR=\"198.51.100.1:4711\";proto=http;by=_us"}) == "198.51.100.1");
  CHECK(by_standard({"host=\"a,b;c\";for=\"[2001:db8::1]:_p\""}) == "2001:db8::1");
  CHECK(by_standard({"for=\"\\1\\98.51.100.1\""}) == "198.51.100.1");
  CHECK(by_standard({"for=1.1.1.1, for=198.51.100.1 ,for=10.0.0.2; proto=https,,"}) ==
        "198.51.100.1");
  CHECK(by_standard({"for=1.1.1.1", "for=198.51.100.1", "for=\"[fd00::7]\""}) == "198.51.100.1");
  CHECK(by_standard({"for=10.0.0.3,for=10.0.0.2"}) == "10.0.0.3");
}

TEST_CASE("of Forwarded, nothing is believed beyond a node that is no address") {
  for (const std::string bad :
       {"for=unknown", "for=_hidden", "for=\"_hidden:80\"", "by=1.1.1.1", "for=\"\"",
        "for=\"1.1.1\"", "for=\"[1.1.1.1]\"", "for=\"2001:db8::1\"", "for=\"[::1\"", "for=\"[]\"",
        "for=\"1.1.1.1:\"", "for=\"1.1.1.1:123456\"", "for=\"1.1.1.1:_\"", "for=\"1.1.1.1:x\"",
        "for=\"1.1.1.1 \"", "for=\"[::1]80\""}) {
    CAPTURE(bad);
    CHECK(by_standard({"for=198.51.100.1," + bad}) == "10.0.0.1");
    CHECK(by_standard({"for=198.51.100.1," + bad + ", for=10.0.0.2"}) == "10.0.0.2");
  }
  CHECK(by_standard({}) == "10.0.0.1");
}

TEST_CASE("of Forwarded, a line with anything that is not of its syntax says nothing") {
  for (const std::string bad :
       {"1.1.1.1", "for", "for=", "for=[::1]", "for=1.1.1.1:80", "for =1.1.1.1", "for= 1.1.1.1",
        "for=1.1.1.1;for=1.1.1.1", "f or=1.1.1.1", "for=\"1.1.1.1", "for=\"1.1.1.1\\\"",
        "for=\"1.1.1.1\"x", "for=1.1.1.1\"", "=1.1.1.1", "for=\"1.1.1.1\x01\""}) {
    CAPTURE(bad);
    CHECK(by_standard({bad}) == "10.0.0.1");
    CHECK(by_standard({bad + ", for=198.51.100.1"}) == "10.0.0.1");
    CHECK(by_standard({"for=198.51.100.1, " + bad}) == "10.0.0.1");
    // What a proxy adds as a line of its own is not spoilt.
    CHECK(by_standard({bad, "for=198.51.100.1"}) == "198.51.100.1");
    CHECK(by_standard({bad, "for=10.0.0.2"}) == "10.0.0.2");
  }
}

TEST_CASE("of a chain without end, 64 proxies are looked at") {
  const auto chain = [](const std::string& one, std::size_t proxies, const std::string& prefix) {
    std::string list = prefix + one;
    for (std::size_t i = 1; i <= proxies; ++i) list += "," + prefix + "10.0.1." + std::to_string(i);
    return list;
  };
  CHECK(client({chain("198.51.100.1", 63, "")}) == "198.51.100.1");
  CHECK(client({chain("198.51.100.1", 64, "")}) == "10.0.1.1");
  CHECK(by_standard({chain("198.51.100.1", 63, "for=")}) == "198.51.100.1");
  CHECK(by_standard({chain("198.51.100.1", 64, "for=")}) == "10.0.1.1");
  CHECK(by_standard({"for=198.51.100.1", chain("10.0.2.1", 63, "for=")}) == "10.0.2.1");
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
  CHECK(ask("/client", "Forwarded: for=1.1.1.1\r\n") == "127.0.0.1");  // not what this one writes
  CHECK(ask("/client", "") == "127.0.0.1");  // nothing is left of who asked last
}

TEST_CASE("a request through a proxy that writes Forwarded is its client's") {
  HttpOptions options = Edge::patient();
  options.trusted_proxies = *AddressRanges::parse("127.0.0.1");
  options.forwarded_header = ForwardedHeader::forwarded;
  Edge edge(std::move(options));
  RawClient raw(edge.port);
  raw.send(get("/client",
               "Forwarded: for=1.1.1.1, for=\"198.51.100.2:1\"\r\n"
               "X-Forwarded-For: 203.0.113.9\r\n"));
  CHECK(raw.receive().body == "198.51.100.2");
}
