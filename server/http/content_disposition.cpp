#include "server/http/content_disposition.h"

#include <utility>

#include "proto/wire/cut_to.h"
#include "server/http/head.h"

namespace geodesic::server {
namespace {

// A token, or a quoted string without its quotes and escapes. Nothing where the quotes do not close
// at the end.
std::optional<std::string> unquoted(std::string_view value) {
  if (!value.starts_with('"')) return std::string(value);
  std::string text;
  for (std::size_t i = 1; i < value.size(); ++i) {
    if (value[i] == '"') {
      if (i + 1 != value.size()) return std::nullopt;
      return text;
    }
    const bool escapes =
        value[i] == '\\' && i + 1 < value.size() && (value[i + 1] == '"' || value[i + 1] == '\\');
    if (escapes) ++i;
    text += value[i];
  }
  return std::nullopt;
}

// An extended value (RFC 8187) in UTF-8: UTF-8'language'percent%20encoded.
std::optional<std::string> extended(std::string_view value) {
  if (!equals_ignoring_case(take_until('\'', value), "UTF-8")) return std::nullopt;
  (void)take_until('\'', value);  // the language
  auto text = percent_decode(value, /*plus_is_space=*/false);
  if (!text || !proto::is_utf8(*text)) return std::nullopt;
  return std::move(*text);
}

}  // namespace

std::optional<std::string> header_parameter(std::string_view header, std::string_view name) {
  (void)take_until(';', header);  // the value itself
  while (!header.empty()) {
    std::string_view value = take_until(';', header);
    const std::string_view key = trimmed(take_until('=', value));
    if (equals_ignoring_case(key, name)) return unquoted(trimmed(value));
  }
  return std::nullopt;
}

std::optional<std::string> file_name_in_disposition(std::string_view header) {
  const auto encoded = header_parameter(header, "filename*");
  auto name = encoded ? extended(*encoded) : std::nullopt;
  if (!name) name = header_parameter(header, "filename");
  if (!name) return std::nullopt;
  return without_folders(std::move(*name));
}

std::string without_folders(std::string path) {
  const auto folders = path.find_last_of("/\\");
  if (folders != std::string::npos) path.erase(0, folders + 1);
  return path == "." || path == ".." ? std::string() : path;
}

}  // namespace geodesic::server
