// How the values of settings are written, in flags, variables and files alike:
// whole numbers, sizes in bytes, addresses.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/error.h"

namespace geodesic::server {

struct Address {
  std::string host;  // IPv6 without brackets; empty: not set
  int port = 0;      // 0: any free one
};

// Each parser fails with `bad_syntax` and a sentence that repeats the text.

[[nodiscard]] Result<std::uint64_t> parse_whole_number(std::string_view text);

// "256MiB" -> bytes. Suffixes KiB, MiB, GiB; none: bytes.
[[nodiscard]] Result<std::uint64_t> parse_bytes(std::string_view text);
[[nodiscard]] std::string format_bytes(std::uint64_t bytes);

// "127.0.0.1:8080", "[::1]:0", "localhost:80", ":8080" (all interfaces).
[[nodiscard]] Result<Address> parse_address(std::string_view text);
[[nodiscard]] std::string format_address(const Address& address);

}  // namespace geodesic::server
