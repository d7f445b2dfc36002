#include "proto/wire/mesh_name.h"

#include "proto/wire/cut_to.h"
#include "proto/wire/input_codes.h"

namespace geodesic::proto {
namespace {

// U+0000 to U+001F, U+007F to U+009F, and what breaks lines (U+2028, U+2029) or turns the direction
// of what follows (U+202A to U+202E, U+2066 to U+2069), in UTF-8.
bool has_control(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (byte(i) < ' ' || byte(i) == 0x7f) return true;
    if (byte(i) == 0xc2 && i + 1 < text.size() && byte(i + 1) < 0xa0) return true;
    if (byte(i) != 0xe2 || i + 2 >= text.size()) continue;
    if (byte(i + 1) == 0x80 && byte(i + 2) >= 0xa8 && byte(i + 2) <= 0xae) return true;
    if (byte(i + 1) == 0x81 && byte(i + 2) >= 0xa6 && byte(i + 2) <= 0xa9) return true;
  }
  return false;
}

}  // namespace

bool is_mesh_name(std::string_view text) {
  return !text.empty() && text.size() <= kMostMeshNameBytes && is_utf8(text) && !has_control(text);
}

Result<std::optional<std::string>> read_mesh_name(Parameters& parameters) {
  auto text = parameters.text("name");
  if (text && *text && !(*text)->empty() && !is_mesh_name(**text)) {
    return fail(InputCode::bad_syntax,
                "a name of at most 200 bytes of UTF-8, without control characters, is wanted",
                "name");
  }
  return text;
}

}  // namespace geodesic::proto
