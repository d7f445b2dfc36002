// What a JSON text may be refused for before its values are made: nesting that is too deep, and a
// name that comes twice in one object. Of two values no reader can know which one is meant, and
// readers differ in which one they take (RFC 8259, section 4).
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace geodesic::proto {

struct JsonOutline {
  std::optional<std::string> repeated_name;  // the first one
  bool is_too_deep = false;                  // more than `most_levels` arrays and objects nested
  std::size_t most_members = 0;              // of one object
};

// Reads the text up to its end, or to where it is too deep or no JSON. Keeps nothing of it but the
// names of the objects that are open. O(n log n), whatever names there are.
[[nodiscard]] JsonOutline outline_of_json(
    std::string_view text, std::size_t most_levels = std::numeric_limits<std::size_t>::max(),
    bool ignore_comments = false);

}  // namespace geodesic::proto
