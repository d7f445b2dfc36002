#include "server/http/prefer.h"

#include "server/http/head.h"

namespace geodesic::server {
namespace {

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
