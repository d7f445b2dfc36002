#include "server/http/entity_tag.h"

#include "server/base/sha256.h"

namespace geodesic::server {

std::string entity_tag(std::string_view content) {
  std::string tag("\"");
  tag.append(sha256_hex(content), 0, 32);
  tag += '"';
  return tag;
}

std::string weak_tag(std::string_view tag) { return "W/" + std::string(tag); }

std::string packed_tag(std::string_view tag) {
  std::string packed(tag.substr(0, tag.size() - 1));
  packed += "-gzip\"";
  return packed;
}

bool is_listed(const HttpRequest& request, std::string_view tag) {
  const std::string* const header = request.header("If-None-Match");
  if (header == nullptr) return false;
  std::string_view list = *header;
  // Both sides without their weakness.
  if (tag.starts_with("W/")) tag.remove_prefix(2);
  // Our tags have no comma; what is not ours matches nothing, wherever it is cut.
  while (!list.empty()) {
    const std::size_t comma = list.find(',');
    std::string_view entry = list.substr(0, comma);
    list = comma == list.npos ? std::string_view() : list.substr(comma + 1);
    while (entry.starts_with(' ') || entry.starts_with('\t')) entry.remove_prefix(1);
    while (entry.ends_with(' ') || entry.ends_with('\t')) entry.remove_suffix(1);
    if (entry.starts_with("W/")) entry.remove_prefix(2);
    if (entry == tag) return true;
  }
  return false;
}

bool has_already(const HttpRequest& request, std::string_view tag) {
  return is_listed(request, tag) || is_listed(request, packed_tag(tag));
}

bool has_any(const HttpRequest& request) {
  const std::string* const header = request.header("If-None-Match");
  return header != nullptr && *header == "*";
}

HttpResponse not_modified(std::string_view tag) {
  HttpResponse response;
  response.status = 304;
  response.set_header("ETag", std::string(tag));
  return response;
}

}  // namespace geodesic::server
