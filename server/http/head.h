// Reads a request's head (request line and headers) strictly: whatever two
// parsers could read differently is refused, because that is how one request is
// smuggled inside another. Pure functions of bytes; RFC 9110 and RFC 9112.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace geodesic::server {

struct HttpHead {
  std::string method;
  std::string target;     // raw
  std::string path;       // percent-decoded: `/` and what needs no escape were not escaped
  std::string authority;  // for whom it is, "host:port": the target's, or the Host header's; or ""
  std::vector<std::pair<std::string, std::string>> query;
  std::vector<std::pair<std::string, std::string>> headers;
  bool http_1_0 = false;
  bool keep_alive = true;        // what the client asks for
  bool chunked = false;          // the body is chunked …
  std::uint64_t body_bytes = 0;  // … or has that many bytes
  bool expects_continue = false;

  // The first header of that name, whatever its case; null if there is none.
  [[nodiscard]] const std::string* header(std::string_view name) const;
};

struct HeadLimits {
  std::size_t target_bytes;
  std::size_t header_count;
};

// An error, and the HTTP status where that is not the one of its code.
struct HeadError {
  Error error;
  int status = 0;  // 0: that of the code
};

// `bytes` runs from the request line to the empty line, both included. On
// failure `head` holds what was understood so far (the log and the reply use
// method, target and X-Request-Id).
[[nodiscard]] std::optional<HeadError> parse_head(std::string_view bytes, const HeadLimits& limits,
                                                  HttpHead& head);

// Undoes percent-encoding. Fails with `bad_syntax` on an incomplete or
// non-hexadecimal escape and on %00. In a query '+' is a space.
[[nodiscard]] Result<std::string> percent_decode(std::string_view text, bool plus_is_space);

// "a=1&b=%20&c" -> pairs in order; a name without '=' has an empty value.
[[nodiscard]] Result<std::vector<std::pair<std::string, std::string>>> parse_query(
    std::string_view text);

// What no line of HTTP may hold within it.
[[nodiscard]] inline bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

// RFC 9110, 5.6.2: what methods and header names are made of.
[[nodiscard]] bool is_token(std::string_view text);

// A host and perhaps a port. Narrower than RFC 3986, 3.2: a name of letters, digits, `-`, `.`,
// `_` and `~` (no escapes, no sub-delims), an IPv4 address, or an IPv6 address in brackets.
[[nodiscard]] bool is_authority(std::string_view text);

// Of ASCII letters.
[[nodiscard]] bool equals_ignoring_case(std::string_view a, std::string_view b);

// Takes off what comes before the first `separator` that is in no quoted string, and that with it.
[[nodiscard]] std::string_view take_until(char separator, std::string_view& text);

// Without the spaces and tabs at either end.
[[nodiscard]] std::string_view trimmed(std::string_view text);

}  // namespace geodesic::server
