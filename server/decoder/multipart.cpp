#include "server/decoder/multipart.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "proto/wire/input_codes.h"

namespace geodesic::server {
namespace {

constexpr std::size_t kMostParts = 1000;
constexpr std::size_t kMostHeaderBytes = 8192;
constexpr std::size_t kMostBoundaryBytes = 70;  // RFC 2046, section 5.1.1

tl::unexpected<Error> no_form(const char* detail) {
  return fail(InputCode::bad_syntax, detail, "body");
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

std::string_view without_blanks(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// `; name=value` or `; name="value"`, whatever the name's case. Browsers write a quote
// within a name as %22.
std::optional<std::string> parameter_of(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    // To the next semicolon outside of quotes.
    std::size_t end = 0;
    bool quoted = false;
    for (; end < header.size() && (quoted || header[end] != ';'); ++end) {
      if (header[end] == '"') quoted = !quoted;
    }
    const std::string_view item = without_blanks(header.substr(0, end));
    header.remove_prefix(std::min(end + 1, header.size()));
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos || lower_case(item.substr(0, equals)) != name) continue;
    std::string_view value = item.substr(equals + 1);
    if (value.size() >= 2 && value.front() == '"' && value.back() == '"') {
      value = value.substr(1, value.size() - 2);
    }
    std::string text(value);
    for (auto at = text.find("%22"); at != std::string::npos; at = text.find("%22", at + 1)) {
      text.replace(at, 3, "\"");
    }
    return text;
  }
  return std::nullopt;
}

// Reads the names out of the head of one part, which is its lines up to the empty one.
Result<Part> part_of(std::string_view head) {
  constexpr std::string_view kDisposition = "content-disposition:";
  while (!head.empty()) {
    const std::size_t end = std::min(head.find("\r\n"), head.size());
    const std::string_view line = head.substr(0, end);
    head.remove_prefix(std::min(end + 2, head.size()));
    if (lower_case(line.substr(0, kDisposition.size())) != kDisposition) continue;
    Part part;
    part.name = parameter_of(line.substr(kDisposition.size()), "name").value_or("");
    part.filename = parameter_of(line.substr(kDisposition.size()), "filename").value_or("");
    return part;
  }
  return no_form("a part has no Content-Disposition");
}

}  // namespace

bool is_multipart(std::string_view content_type) {
  return lower_case(without_blanks(content_type.substr(0, content_type.find(';')))) ==
         "multipart/form-data";
}

std::optional<std::string> multipart_boundary(std::string_view content_type) {
  if (!is_multipart(content_type)) return std::nullopt;
  auto boundary = parameter_of(content_type, "boundary");
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
    if (line == std::string_view::npos || !without_blanks(body.substr(0, line)).empty()) {
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
