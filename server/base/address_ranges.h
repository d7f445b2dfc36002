// A set of IP addresses, written as addresses and CIDR ranges (RFC 4632; RFC 4291, 2.3).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace geodesic::server {

class AddressRanges {
 public:
  // "10.0.0.0/8, 127.0.0.1, 2001:db8::/32": commas between them, spaces or not. Nothing if one is
  // neither an address nor a range, or has bits set beyond its prefix. An empty text is an empty
  // set.
  [[nodiscard]] static std::optional<AddressRanges> parse(std::string_view text);

  // Whether one of the ranges holds this numeric address. An IPv4 address is the same as its
  // mapped IPv6 one (::ffff:10.0.0.1). A zone (%eth0) is not looked at. False for other text.
  [[nodiscard]] bool contains(std::string_view address) const;
  [[nodiscard]] bool empty() const { return ranges_.empty(); }

 private:
  using Bytes = std::array<std::uint8_t, 16>;  // of IPv6
  struct Range {
    Bytes address;
    unsigned bits;  // of the prefix, of 128
  };

  static std::optional<Bytes> bytes_of(std::string_view address);
  // The address with all bits after the prefix cleared.
  static Bytes cut(Bytes address, unsigned bits);

  std::vector<Range> ranges_;
};

}  // namespace geodesic::server
