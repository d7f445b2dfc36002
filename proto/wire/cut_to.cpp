#include "proto/wire/cut_to.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

namespace geodesic::proto {

std::string cut_to(std::string_view text, std::size_t most) {
  if (text.size() <= most) return std::string(text);
  constexpr std::string_view kEllipsis = "…";
  std::size_t end = most - kEllipsis.size();
  // Not within a character, if it is one.
  constexpr std::size_t kLongestCharacter = 4;
  const std::size_t least = end - std::min(end, kLongestCharacter);
  const auto is_within = [&] { return (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80; };
  while (end > least && is_within()) --end;
  return std::string(text.substr(0, end)).append(kEllipsis);
}

std::string as_utf8(std::string_view text) {
  using nlohmann::json;
  const std::string replaced = json(text).dump(-1, ' ', false, json::error_handler_t::replace);
  return json::parse(replaced).get<std::string>();
}

bool is_utf8(std::string_view text) { return as_utf8(text) == text; }

}  // namespace geodesic::proto
