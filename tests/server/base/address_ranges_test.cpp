#include "server/base/address_ranges.h"

#include <arpa/inet.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <string>

#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using geodesic::server::AddressRanges;

namespace {

AddressRanges ranges(const std::string& text) {
  const auto parsed = AddressRanges::parse(text);
  REQUIRE_MESSAGE(parsed.has_value(), text);
  return *parsed;
}

}  // namespace

TEST_CASE("addresses are in the ranges that hold them") {
  const AddressRanges some = ranges("10.0.0.0/8, 192.168.1.7 ,2001:db8::/33,\t::1");
  for (const char* in : {"10.0.0.0", "10.255.255.255", "192.168.1.7", "2001:db8:7fff::1", "::1",
                         "::ffff:10.1.2.3", "::1%lo"}) {
    CHECK_MESSAGE(some.contains(in), in);
  }
  for (const char* out :
       {"11.0.0.0", "9.255.255.255", "192.168.1.8", "2001:db8:8000::", "::2", "::ffff:11.0.0.1",
        "::10.0.0.1", "", "10.0.0", "localhost", "10.0.0.1:80"}) {
    CHECK_FALSE_MESSAGE(some.contains(out), out);
  }
  CHECK(ranges("0.0.0.0/0").contains("1.2.3.4"));
  CHECK_FALSE(ranges("0.0.0.0/0").contains("2001:db8::1"));
  CHECK(ranges("::/0").contains("1.2.3.4"));
  CHECK(ranges("::ffff:0.0.0.0/96").contains("1.2.3.4"));
  for (const char* empty : {"", " ", "\t"}) {
    CHECK(ranges(empty).empty());
    CHECK_FALSE(ranges(empty).contains("::1"));
  }
}

TEST_CASE("what is no list of ranges is refused") {
  for (const char* bad :
       {",", "10.0.0.0/8,", "10.0.0.1/8", "10.0.0.0/33", "10.0.0.0/", "10.0.0.0/-1", "10.0.0.0/8/8",
        "10.0.0", "10.0.0.0 /8 10.1.0.0", "::/129", "::1/64", "2001:db8::%1", "proxy.example", "/8",
        "10.0.0.0/8;::1", "10.0.0.0/0x8", "10.0.0.0/ 8", "*"}) {
    CHECK_FALSE_MESSAGE(AddressRanges::parse(bad).has_value(), bad);
  }
}

// Against the first bits of both, written as text.
TEST_CASE("random ranges hold the addresses that begin as they do, and no other") {
  std::mt19937 random(fixtures::test_seed());
  using Bytes = std::array<std::uint8_t, 16>;
  const auto bits_of = [](const Bytes& bytes, std::size_t count) {
    std::string bits;
    for (std::size_t i = 0; i < 8 * count; ++i) {
      bits += static_cast<char>('0' + (bytes[i / 8] >> (7 - i % 8) & 1));
    }
    return bits;
  };
  for (int round = 0; round < 2000; ++round) {
    const bool is_v6 = random() % 2 == 0;
    const std::size_t count = is_v6 ? 16 : 4;
    const auto format = [&](const Bytes& bytes) {
      std::array<char, INET6_ADDRSTRLEN> text{};
      ::inet_ntop(is_v6 ? AF_INET6 : AF_INET, bytes.data(), text.data(), text.size());
      return std::string(text.data());
    };
    Bytes range{};
    for (std::uint8_t& byte : range) byte = static_cast<std::uint8_t>(random());
    const std::size_t prefix = random() % (8 * count + 1);
    for (std::size_t i = prefix; i < 8 * count; ++i) {
      range[i / 8] &= static_cast<std::uint8_t>(~(0x80u >> (i % 8)));
    }
    Bytes address = range;
    for (std::size_t i = prefix; i < 8 * count; ++i) {
      if (random() % 2 == 0) address[i / 8] ^= static_cast<std::uint8_t>(0x80u >> (i % 8));
    }
    if (random() % 2 == 0)
      address[random() % count] ^= static_cast<std::uint8_t>(1u << random() % 8);
    const std::string text = format(range) + "/" + std::to_string(prefix);
    CAPTURE(text);
    CAPTURE(format(address));
    const bool expected =
        bits_of(address, count).substr(0, prefix) == bits_of(range, count).substr(0, prefix);
    CHECK(ranges(text).contains(format(address)) == expected);
  }
}
