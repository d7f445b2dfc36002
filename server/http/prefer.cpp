#include "server/http/prefer.h"

#include "server/http/head.h"

namespace geodesic::server {
namespace {

// Takes off what comes before the first `separator` that is in no quoted string.
std::string_view take_until(char separator, std::string_view& text) {
  bool quoted = false;
  std::size_t end = 0;
  for (; end < text.size() && (quoted || text[end] != separator); ++end) {
    if (text[end] == '"') quoted = !quoted;
    if (text[end] == '\\' && quoted) ++end;
  }
  const std::string_view taken = text.substr(0, end);
  text = end < text.size() ? text.substr(end + 1) : std::string_view();
  return taken;
}

// A list of `name[=value][;parameters]`.
bool has_preference(std::string_view list, std::string_view name) {
  while (!list.empty()) {
    std::string_view preference = take_until(',', list);
    std::string_view value = take_until(';', preference);
    const bool is_it = equals_ignoring_case(trimmed(take_until('=', value)), name);
    value = trimmed(value);
    if (is_it && (value.empty() || value == "\"\"")) return true;
  }
  return false;
}

}  // namespace

bool prefers(const HttpRequest& request, std::string_view name) {
  for (const auto& [key, value] : request.headers) {
    if (equals_ignoring_case(key, "Prefer") && has_preference(value, name)) return true;
  }
  return false;
}

}  // namespace geodesic::server
