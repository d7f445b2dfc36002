// Words of a stranger's that are told again: no more of them than anyone would read.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace geodesic::proto {

// A text within so many bytes of UTF-8, at least 3: of a longer one its beginning, and "…".
[[nodiscard]] std::string cut_to(std::string_view text, std::size_t most);

}  // namespace geodesic::proto
