// Words of a stranger's that are told again: no more of them than anyone would read.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace geodesic::proto {

// A text within so many bytes of UTF-8, at least 3: of a longer one its beginning, and "…".
[[nodiscard]] std::string cut_to(std::string_view text, std::size_t most);

// The text, with U+FFFD in place of what is no well-formed UTF-8, as JSON tells it.
[[nodiscard]] std::string as_utf8(std::string_view text);

// Whether the bytes are well-formed UTF-8 (RFC 3629).
[[nodiscard]] bool is_utf8(std::string_view text);

}  // namespace geodesic::proto
