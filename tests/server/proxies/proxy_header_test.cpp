// PROXY headers of version 2 as bytes, however they are cut.
#include "server/proxies/proxy_header.h"

#include <arpa/inet.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <random>
#include <string>

#include "tests/fixtures/test_seed.h"
#include "tests/server/proxies/announce.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using State = ProxyHeader::State;

namespace {

// Of all that was sent; `used` is how much of it the header was.
struct Read {
  State state = State::more;
  std::string source;
  std::string fault;
  std::size_t used = 0;
};

// In pieces of at most `piece` bytes.
Read read(std::string_view bytes, std::size_t piece = 4096) {
  ProxyHeader header;
  Read result;
  while (result.state == State::more && result.used < bytes.size()) {
    REQUIRE(header.missing() > 0);
    const std::string_view part = bytes.substr(result.used, std::min(piece, header.missing()));
    result.used += part.size();
    result.state = header.take(part);
  }
  result.source = header.source();
  result.fault = header.fault();
  return result;
}

}  // namespace

TEST_CASE("a header as HAProxy writes it names the client") {
  const std::string written(
      "\x0d\x0a\x0d\x0a\x00\x0d\x0a\x51\x55\x49\x54\x0a\x21\x11\x00\x0c"
      "\xc6\x33\x64\x07\xc0\x00\x02\x01\xd4\x31\x01\xbb",
      28);
  for (std::size_t piece = 1; piece <= written.size(); ++piece) {
    const Read all = read(written + "GET / HTTP/1.1\r\n", piece);
    CHECK(all.state == State::complete);
    CHECK(all.source == "198.51.100.7");
    CHECK(all.used == written.size());
  }
  CHECK(read(announce("2001:db8::7", "::1")).source == "2001:db8::7");
}

TEST_CASE("a proxy that speaks for itself, or of no address, names nobody") {
  for (const std::string& bytes :
       {header_of(0x20, 0x00, ""), header_of(0x20, 0x11, std::string(12, '\x01')),
        header_of(0x20, 0x11, "short"), header_of(0x20, 0xff, ""), header_of(0x21, 0x00, ""),
        header_of(0x21, 0x00, std::string(100, 'x')),
        header_of(0x21, 0x31, std::string(216, 'x'))}) {
    const Read all = read(bytes + "more");
    CHECK(all.state == State::complete);
    CHECK(all.source.empty());
    CHECK(all.used == bytes.size());
  }
}

TEST_CASE("what is no header of version 2 is refused, and said to be what it is") {
  const std::string addresses(216, '\x01');
  CHECK(read("PROXY TCP4 1.2.3.4 5.6.7.8 1 2\r\n").fault.find("version 1") != std::string::npos);
  for (const std::string& bytes :
       {std::string("GET / HTTP/1.1\r\n"), std::string("POST / HTTP/1.1\r\n"),
        std::string("\x16\x03\x01\x02\x00\x01", 6), std::string("\r\n\r\nGET"),
        std::string("PROXX"), header_of(0x11, 0x11, addresses), header_of(0x31, 0x11, addresses),
        header_of(0x22, 0x11, addresses), header_of(0x21, 0x12, addresses),
        header_of(0x21, 0x22, addresses), header_of(0x21, 0x32, addresses),
        header_of(0x21, 0x01, addresses), header_of(0x21, 0x41, addresses),
        header_of(0x21, 0x11, std::string(11, 'x')), header_of(0x21, 0x21, std::string(35, 'x')),
        header_of(0x21, 0x31, std::string(215, 'x'))}) {
    CAPTURE(bytes);
    CHECK(read(bytes).state == State::refused);
    CHECK(read(bytes).fault.find("version 1") == std::string::npos);
    CHECK(read(bytes, 1).fault == read(bytes).fault);
    CHECK(read(bytes, 1).used <= 16);
  }
}

TEST_CASE("random headers name whom they were made for, however they are cut") {
  std::mt19937 random(fixtures::test_seed());
  const auto below = [&](std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
  };
  for (int draw = 0; draw < 2000; ++draw) {
    const bool is_v6 = below(2) == 1;
    std::string addresses(is_v6 ? 36 : 12, '\0');
    for (char& c : addresses) c = static_cast<char>(below(256));
    std::string behind(below(8) == 0 ? below(65'000) : below(300), '\0');
    for (char& c : behind) c = static_cast<char>(below(256));
    const std::string header = header_of(0x21, is_v6 ? 0x21 : 0x11, addresses + behind);
    const Read all = read(header + "GET", 1 + below(600));
    CHECK(all.state == State::complete);
    CHECK(all.used == header.size());
    std::array<char, 16> bytes{};
    REQUIRE(::inet_pton(is_v6 ? AF_INET6 : AF_INET, all.source.c_str(), bytes.data()) == 1);
    CHECK(std::string(bytes.data(), is_v6 ? 16 : 4) == addresses.substr(0, is_v6 ? 16 : 4));
    CHECK(read(header.substr(0, below(header.size())), 1 + below(600)).state == State::more);
  }
}
