#include "server/http/head.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <charconv>

#include "proto/wire/input_codes.h"

namespace geodesic::server {

namespace {

HeadError bad(std::string detail, std::string parameter = {}, int status = 0) {
  return {Error{InputCode::bad_syntax, std::move(detail), std::move(parameter), {}, {}}, status};
}

HeadError over_limit(std::string detail, int status, std::uint64_t limit, std::uint64_t actual) {
  return {Error{ErrorCode::too_large, std::move(detail), {}, limit, actual}, status};
}

HeadError unsupported(std::string detail, std::string parameter, int status) {
  return {Error{ErrorCode::unsupported, std::move(detail), std::move(parameter), {}, {}}, status};
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Cuts one line off `bytes`, its CR LF included. A bare CR or LF ends no line:
// it stays inside, where it is refused as a control character.
std::string_view take_line(std::string_view& bytes) {
  const std::size_t end = bytes.find("\r\n");
  const std::string_view line = bytes.substr(0, end);
  bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + 2);
  return line;
}

// Whether a comma-separated header value lists `token`, whatever its case.
bool lists(std::string_view value, std::string_view token) {
  while (!value.empty()) {
    const std::size_t comma = value.find(',');
    if (equals_ignoring_case(trimmed(value.substr(0, comma)), token)) return true;
    if (comma == std::string_view::npos) break;
    value.remove_prefix(comma + 1);
  }
  return false;
}

int hex_digit(char c) {
  if (is_digit(c)) return c - '0';
  if (lower(c) >= 'a' && lower(c) <= 'f') return lower(c) - 'a' + 10;
  return -1;
}

// RFC 3986, 2.3: what means the same whether it is percent-encoded or not.
bool is_unreserved(char c) {
  return is_digit(c) || (lower(c) >= 'a' && lower(c) <= 'z') || c == '-' || c == '.' || c == '_' ||
         c == '~';
}

// A host in brackets, which are stripped: an IPv6 address.
bool is_ipv6(std::string_view address) {
  in6_addr bytes{};
  return address.size() < INET6_ADDRSTRLEN &&
         ::inet_pton(AF_INET6, std::string(address).c_str(), &bytes) == 1;
}

// Names of labels with dots between them, one at the end allowed; IPv4 addresses look so too.
bool is_name(std::string_view host) {
  if (host.ends_with('.')) host.remove_suffix(1);
  return !host.empty() && !host.starts_with('.') && !host.ends_with('.') &&
         host.find("..") == std::string_view::npos &&
         std::all_of(host.begin(), host.end(), is_unreserved);
}

// Refuses an escaped character that means the same bare, and an escaped slash: who filters
// paths in front of us might see another path than we do.
std::optional<HeadError> check_escapes(std::string_view path) {
  for (std::size_t at = path.find('%'); at != path.npos; at = path.find('%', at + 1)) {
    const int high = at + 1 < path.size() ? hex_digit(path[at + 1]) : -1;
    const int low = at + 2 < path.size() ? hex_digit(path[at + 2]) : -1;
    if (high < 0 || low < 0) continue;  // told when it is decoded
    const char c = static_cast<char>(16 * high + low);
    if (is_unreserved(c)) {
      return bad("the path escapes a character that is to be written as it is");
    }
    if (c == '/' || c == '\\') return bad("the path holds an escaped slash");
  }
  return {};
}

std::optional<HeadError> parse_target(HttpHead& head) {
  std::string_view target = head.target;
  if (target == "*" && head.method == "OPTIONS") {
    head.path = "*";
    return {};
  }
  // The absolute form, which proxies send. Its authority counts, and not the Host header.
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!equals_ignoring_case(target.substr(0, scheme.size()), scheme)) continue;
    const std::size_t end = std::min(target.find_first_of("/?#", scheme.size()), target.size());
    head.authority = target.substr(scheme.size(), end - scheme.size());
    // Here others take letters, digits, hyphens and dots only.
    if (!is_authority(head.authority) || head.authority.find_first_of("_~") != std::string::npos) {
      return bad("the request target names no host");
    }
    target = end == target.size() ? std::string_view("/") : target.substr(end);
    break;
  }
  if (target.empty() || target.front() != '/') {
    return bad("the request target must start with '/'");
  }
  if (target.find('#') != std::string_view::npos) {
    return bad("a request target has no fragment");
  }
  const std::size_t mark = target.find('?');
  if (auto error = check_escapes(target.substr(0, mark))) return error;
  Result<std::string> path = percent_decode(target.substr(0, mark), /*plus_is_space=*/false);
  if (!path) return HeadError{std::move(path.error())};
  head.path = std::move(*path);
  if (mark != std::string_view::npos) {
    auto query = parse_query(target.substr(mark + 1));
    if (!query) return HeadError{std::move(query.error())};
    head.query = std::move(*query);
  }
  return {};
}

std::optional<HeadError> parse_request_line(std::string_view line, const HeadLimits& limits,
                                            HttpHead& head) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) {
    return bad("the request line is not 'METHOD target HTTP/1.1'");
  }
  const std::string_view method = line.substr(0, first);
  const std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  if (!is_token(method) || method.size() > 32) return bad("the HTTP method is not a token");
  head.method = method;
  if (target.size() > limits.target_bytes) {
    return over_limit("the request target is too long; POST takes the parameters in its body", 414,
                      limits.target_bytes, target.size());
  }
  if (std::any_of(target.begin(), target.end(), [](char c) { return is_control(c) || c == ' '; })) {
    return bad("the request target holds a space or a control character");
  }
  head.target = target;
  if (version.size() != 8 || !version.starts_with("HTTP/") || !is_digit(version[5]) ||
      version[6] != '.' || !is_digit(version[7])) {
    return bad("the request line does not end in an HTTP version");
  }
  if (version[5] != '1') {
    return unsupported("only HTTP/1.1 and HTTP/1.0 are spoken here", "", 505);
  }
  head.http_1_0 = version[7] == '0';
  return {};
}

bool decides_framing(std::string_view name) {
  return equals_ignoring_case(name, "Host") || equals_ignoring_case(name, "Content-Length") ||
         equals_ignoring_case(name, "Transfer-Encoding");
}

std::optional<HeadError> parse_headers(std::string_view bytes, const HeadLimits& limits,
                                       HttpHead& head) {
  while (true) {
    const std::string_view line = take_line(bytes);
    if (line.empty()) break;
    if (head.headers.size() == limits.header_count) {
      return over_limit("too many headers", 431, limits.header_count, head.headers.size() + 1);
    }
    const std::size_t colon = line.find(':');
    // A space before the colon or at the start of the line (folding) fails here.
    if (colon == std::string_view::npos || !is_token(line.substr(0, colon))) {
      return bad("a header line is not 'name: value'");
    }
    const std::string_view name = line.substr(0, colon);
    const std::string_view value = trimmed(line.substr(colon + 1));
    // A tab around a value is a blank to some and part of the value to others.
    if (line.find('\t', colon) != line.npos && decides_framing(name)) {
      return bad("a header that says where a request ends or goes holds a tab", std::string(name));
    }
    if (std::any_of(value.begin(), value.end(),
                    [](char c) { return is_control(c) && c != '\t'; })) {
      return bad("a header value holds a control character", std::string(name));
    }
    head.headers.emplace_back(name, value);
  }
  if (!bytes.empty()) return bad("bytes after the empty line of a head");
  return {};
}

// How long the body is; RFC 9112, 6.3, without any of its leniency.
std::optional<HeadError> parse_framing(HttpHead& head) {
  const std::string* length = nullptr;
  const std::string* coding = nullptr;
  const std::string* host = nullptr;
  for (const auto& [name, value] : head.headers) {
    for (const auto& [known, slot] : {std::pair{std::string_view("Content-Length"), &length},
                                      std::pair{std::string_view("Transfer-Encoding"), &coding},
                                      std::pair{std::string_view("Host"), &host}}) {
      if (!equals_ignoring_case(name, known)) continue;
      if (*slot != nullptr) return bad("more than one " + std::string(known), std::string(known));
      *slot = &value;
    }
  }
  if (host == nullptr && !head.http_1_0) return bad("HTTP/1.1 requires a Host header", "Host");
  if (host != nullptr) {
    if (!is_authority(*host)) return bad("the Host header names no host", "Host");
    head.authority = *host;
  }
  if (length != nullptr && coding != nullptr) {
    return bad("Content-Length together with Transfer-Encoding", "Transfer-Encoding");
  }
  if (coding != nullptr) {
    if (head.http_1_0) return bad("HTTP/1.0 has no Transfer-Encoding", "Transfer-Encoding");
    if (!equals_ignoring_case(*coding, "chunked")) {
      return unsupported("the only transfer coding understood is 'chunked'", "Transfer-Encoding",
                         501);
    }
    head.chunked = true;
  }
  if (length != nullptr) {
    const char* const end = length->data() + length->size();
    const auto [stop, error] = std::from_chars(length->data(), end, head.body_bytes);
    // from_chars takes no sign, no space and no prefix for an unsigned number.
    if (error != std::errc() || stop != end) {
      return bad("Content-Length is not a number of bytes", "Content-Length");
    }
  }
  return {};
}

std::optional<HeadError> parse_wishes(HttpHead& head) {
  head.keep_alive = !head.http_1_0;
  for (const auto& [name, value] : head.headers) {
    if (equals_ignoring_case(name, "Connection") && lists(value, "close")) head.keep_alive = false;
    if (equals_ignoring_case(name, "Expect")) {
      if (!equals_ignoring_case(value, "100-continue")) {
        return unsupported("the only expectation met is '100-continue'", "Expect", 417);
      }
      head.expects_continue = !head.http_1_0;
    }
  }
  return {};
}

}  // namespace

bool equals_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower(x) == lower(y); });
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

bool is_token(std::string_view text) {
  constexpr std::string_view kMarks = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    return is_digit(c) || (lower(c) >= 'a' && lower(c) <= 'z') ||
           kMarks.find(c) != std::string_view::npos;
  });
}

bool is_authority(std::string_view text) {
  std::string_view host = text;
  std::string_view port;
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    if (end == std::string_view::npos || !is_ipv6(host.substr(1, end - 1))) return false;
    port = host.substr(end + 1);
  } else {
    const std::size_t colon = std::min(host.find(':'), host.size());
    port = host.substr(colon);
    if (!is_name(host.substr(0, colon))) return false;
  }
  if (port.empty()) return true;
  if (port.front() != ':') return false;
  port.remove_prefix(1);
  if (port.empty()) return true;  // RFC 3986, 3.2.3: that of the scheme
  std::uint16_t number = 0;
  const auto [stop, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  return error == std::errc() && stop == port.data() + port.size();
}

const std::string* HttpHead::header(std::string_view name) const {
  for (const auto& [key, value] : headers) {
    if (equals_ignoring_case(key, name)) return &value;
  }
  return nullptr;
}

std::optional<HeadError> parse_head(std::string_view bytes, const HeadLimits& limits,
                                    HttpHead& head) {
  if (auto error = parse_request_line(take_line(bytes), limits, head)) return error;
  // Headers before the target: the reply to a bad target still echoes X-Request-Id.
  if (auto error = parse_headers(bytes, limits, head)) return error;
  if (auto error = parse_framing(head)) return error;
  if (auto error = parse_target(head)) return error;
  return parse_wishes(head);
}

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

Result<std::string> percent_decode(std::string_view text, bool plus_is_space) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+' && plus_is_space) {
      out += ' ';
    } else if (text[i] != '%') {
      out += text[i];
    } else {
      const int high = i + 1 < text.size() ? hex_digit(text[i + 1]) : -1;
      const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
      if (high < 0 || low < 0) {
        return fail(InputCode::bad_syntax, "'%' must be followed by two hexadecimal digits");
      }
      const int byte = 16 * high + low;
      if (byte == 0) return fail(InputCode::bad_syntax, "%00 is not accepted in a request target");
      out += static_cast<char>(byte);
      i += 2;
    }
  }
  return out;
}

Result<std::vector<std::pair<std::string, std::string>>> parse_query(std::string_view text) {
  std::vector<std::pair<std::string, std::string>> pairs;
  while (!text.empty()) {
    const std::size_t end = text.find('&');
    const std::string_view item = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (item.empty()) continue;
    const std::size_t equals = item.find('=');
    auto name = percent_decode(item.substr(0, equals), /*plus_is_space=*/true);
    if (!name) return fail(std::move(name.error()));
    Result<std::string> value;
    if (equals != std::string_view::npos) {
      value = percent_decode(item.substr(equals + 1), /*plus_is_space=*/true);
    }
    if (!value) {
      value.error().parameter = *name;
      return fail(std::move(value.error()));
    }
    pairs.emplace_back(std::move(*name), std::move(*value));
  }
  return pairs;
}

}  // namespace geodesic::server
