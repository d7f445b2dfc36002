#include "server/config/values.h"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <charconv>
#include <limits>
#include <utility>

#include "proto/wire/input_codes.h"

namespace geodesic::server {

namespace {

tl::unexpected<Error> bad(std::string detail) {
  return fail(InputCode::bad_syntax, std::move(detail));
}

}  // namespace

Result<std::uint64_t> parse_whole_number(std::string_view text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) {
    return bad(fmt::format("'{}' is not a whole number", text));
  }
  return value;
}

std::string format_bytes(std::uint64_t bytes) {
  constexpr std::array<std::string_view, 3> kSuffixes{"KiB", "MiB", "GiB"};
  for (int i = 2; i >= 0; --i) {
    const std::uint64_t unit = std::uint64_t{1} << (10 * (i + 1));
    if (bytes != 0 && bytes % unit == 0) {
      return fmt::format("{}{}", bytes / unit, kSuffixes[static_cast<std::size_t>(i)]);
    }
  }
  return std::to_string(bytes);
}

std::string format_address(const Address& address) {
  if (address.host.empty()) return "";
  const bool is_ipv6 = address.host.find(':') != std::string::npos;
  return fmt::format("{}{}{}:{}", is_ipv6 ? "[" : "", address.host, is_ipv6 ? "]" : "",
                     address.port);
}

Result<std::uint64_t> parse_bytes(std::string_view text) {
  std::uint64_t unit = 1;
  std::string_view digits = text;
  for (const auto& [suffix, factor] :
       {std::pair{std::string_view("KiB"), std::uint64_t{1} << 10},
        std::pair{std::string_view("MiB"), std::uint64_t{1} << 20},
        std::pair{std::string_view("GiB"), std::uint64_t{1} << 30}}) {
    if (text.ends_with(suffix)) {
      unit = factor;
      digits.remove_suffix(suffix.size());
    }
  }
  const auto count = parse_whole_number(digits);
  if (!count || *count > std::numeric_limits<std::uint64_t>::max() / unit) {
    return bad(fmt::format("'{}' is not a number of bytes, such as 1048576, 512KiB or 2GiB", text));
  }
  return *count * unit;
}

Result<Address> parse_address(std::string_view text) {
  const auto refuse = [&] {
    return bad(fmt::format("'{}' is not HOST:PORT, such as 127.0.0.1:8080 or [::1]:0", text));
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return refuse();
  std::string_view host = text.substr(0, colon);
  const auto port = parse_whole_number(text.substr(colon + 1));
  if (!port || *port > 65535) return refuse();
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
    if (host.empty()) return refuse();
  } else if (host.find(':') != std::string_view::npos) {
    return refuse();  // IPv6 needs its brackets, or the port is ambiguous
  }
  return Address{host.empty() ? "0.0.0.0" : std::string(host), static_cast<int>(*port)};
}

}  // namespace geodesic::server
