#include "server/base/address_ranges.h"

#include <arpa/inet.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string>

namespace geodesic::server {

namespace {

constexpr std::size_t kMappedBytes = 12;  // of an IPv6 address before those of IPv4

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpaces = " \t";
  const std::size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpaces) - begin + 1);
}

// At most `most`; nothing for anything but digits.
std::optional<unsigned> prefix_length(std::string_view text, unsigned most) {
  unsigned bits = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, bits);
  if (error != std::errc() || stop != end || bits > most) return std::nullopt;
  return bits;
}

}  // namespace

std::optional<AddressRanges::Bytes> AddressRanges::bytes_of(std::string_view address) {
  const std::string bare(address.substr(0, address.find('%')));
  Bytes bytes{};
  if (::inet_pton(AF_INET6, bare.c_str(), bytes.data()) == 1) return bytes;
  if (::inet_pton(AF_INET, bare.c_str(), bytes.data() + kMappedBytes) != 1) return std::nullopt;
  bytes[10] = bytes[11] = 0xff;
  return bytes;
}

AddressRanges::Bytes AddressRanges::cut(Bytes address, unsigned bits) {
  for (unsigned i = 0; i < address.size(); ++i) {
    const unsigned kept = std::clamp(bits, 8 * i, 8 * i + 8) - 8 * i;  // of this byte
    address[i] &= static_cast<std::uint8_t>(0xff00u >> kept);
  }
  return address;
}

std::optional<AddressRanges> AddressRanges::parse(std::string_view text) {
  AddressRanges parsed;
  if (trimmed(text).empty()) return parsed;
  for (bool more = true; more;) {
    const std::size_t comma = text.find(',');
    more = comma != std::string_view::npos;
    const std::string_view item = trimmed(text.substr(0, comma));
    if (more) text.remove_prefix(comma + 1);

    const std::size_t slash = item.find('/');
    const std::string_view address = item.substr(0, slash);
    const auto bytes =
        address.find('%') == std::string_view::npos ? bytes_of(address) : std::nullopt;
    if (!bytes) return std::nullopt;
    const unsigned own_bits = address.find(':') == std::string_view::npos ? 32 : 128;
    const auto prefix = slash == std::string_view::npos
                            ? std::optional<unsigned>(own_bits)
                            : prefix_length(item.substr(slash + 1), own_bits);
    if (!prefix) return std::nullopt;
    const unsigned bits = 128 - own_bits + *prefix;
    if (cut(*bytes, bits) != *bytes) return std::nullopt;
    parsed.ranges_.push_back({*bytes, bits});
  }
  return parsed;
}

bool AddressRanges::contains(std::string_view address) const {
  const auto bytes = bytes_of(address);
  return bytes && std::any_of(ranges_.begin(), ranges_.end(), [&](const Range& range) {
           return cut(*bytes, range.bits) == range.address;
         });
}

}  // namespace geodesic::server
