#include "server/http/multipart.h"

#include <algorithm>
#include <utility>

#include "proto/wire/input_codes.h"
#include "server/http/content_disposition.h"
#include "server/http/head.h"

namespace geodesic::server {
namespace {

constexpr std::size_t kMostParts = 1000;
constexpr std::size_t kMostHeaderBytes = 8192;
constexpr std::size_t kMostBoundaryBytes = 70;  // RFC 2046, section 5.1.1

tl::unexpected<Error> no_form(const char* detail) {
  return fail(InputCode::bad_syntax, detail, "body");
}

// A name as forms write it: browsers send a quote within as %22.
std::string in_form(std::string_view disposition, std::string_view parameter) {
  std::string text = header_parameter(disposition, parameter).value_or("");
  for (auto at = text.find("%22"); at != std::string::npos; at = text.find("%22", at + 1)) {
    text.replace(at, 3, "\"");
  }
  return text;
}

// Reads the names out of the head of one part, which is its lines up to the empty one.
Result<Part> part_of(std::string_view head) {
  while (!head.empty()) {
    const std::size_t end = std::min(head.find("\r\n"), head.size());
    std::string_view line = head.substr(0, end);
    head.remove_prefix(std::min(end + 2, head.size()));
    if (!equals_ignoring_case(take_until(':', line), "content-disposition")) continue;
    std::string disposition(line);
    // Browsers escape no backslash: one before the last quote is the name's end, unless that is
    // escaped itself.
    if (disposition.ends_with("\\\"") && !disposition.ends_with("\\\\\"")) {
      disposition.insert(disposition.size() - 2, 1, '\\');
    }
    Part part;
    part.name = in_form(disposition, "name");
    part.filename = in_form(disposition, "filename");
    return part;
  }
  return no_form("a part has no Content-Disposition");
}

}  // namespace

bool is_multipart(std::string_view content_type) {
  return equals_ignoring_case(trimmed(take_until(';', content_type)), "multipart/form-data");
}

std::optional<std::string> multipart_boundary(std::string_view content_type) {
  if (!is_multipart(content_type)) return std::nullopt;
  auto boundary = header_parameter(content_type, "boundary");
  if (!boundary || boundary->empty() || boundary->size() > kMostBoundaryBytes) return std::nullopt;
  return boundary;
}

Result<std::vector<Part>> read_multipart(std::string_view body, std::string_view boundary) {
  const std::string delimiter = "\r\n--" + std::string(boundary);
  // The first one may lack the line break, when nothing is before it.
  if (body.starts_with(std::string_view(delimiter).substr(2))) {
    body.remove_prefix(delimiter.size() - 2);
  } else {
    const std::size_t first = body.find(delimiter);
    if (first == std::string_view::npos) return no_form("the boundary is not in the body");
    body.remove_prefix(first + delimiter.size());
  }
  std::vector<Part> parts;
  while (!body.starts_with("--")) {
    if (parts.size() == kMostParts) return no_form("the body has too many parts");
    const std::size_t line = body.find("\r\n");
    if (line == std::string_view::npos || !trimmed(body.substr(0, line)).empty()) {
      return no_form("the boundary is not followed by a line break");
    }
    const std::size_t blank = body.substr(0, line + kMostHeaderBytes).find("\r\n\r\n", line);
    if (blank == std::string_view::npos) return no_form("a part's headers have no end");
    auto part = part_of(body.substr(line + 2, blank > line ? blank - line - 2 : 0));
    if (!part) return fail(std::move(part.error()));
    body.remove_prefix(blank + 4);
    const std::size_t end = body.find(delimiter);
    if (end == std::string_view::npos) return no_form("the last boundary is missing");
    part->bytes = body.substr(0, end);
    parts.push_back(std::move(*part));
    body.remove_prefix(end + delimiter.size());
  }
  return parts;
}

}  // namespace geodesic::server
