#include "server/http/finish_reply.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>

#include "server/http/cross_origin.h"
#include "server/http/entity_tag.h"
#include "server/http/gzip.h"

namespace geodesic::server {
namespace {

constexpr std::size_t kLeastPacked = 1024;  // bytes

const std::string* header_of(const HttpResponse& response, std::string_view name) {
  for (const auto& [key, value] : response.headers) {
    if (key == name) return &value;
  }
  return nullptr;
}

bool is_text(std::string_view type) {
  return type.starts_with("text/") || type.starts_with("application/json") ||
         type.starts_with("application/problem+json") || type.starts_with("application/yaml") ||
         type.starts_with("application/x-ndjson");
}

// Whether it is to be packed for who asks, and is not yet.
bool is_worth_packing(const HttpRequest& request, const HttpResponse& response) {
  return is_text(response.content_type) && !response.stream && response.body &&
         response.body->size() > kLeastPacked && admits_gzip(request) &&
         header_of(response, "Content-Encoding") == nullptr;
}

void set_packed_tag(HttpResponse& response) {
  if (const std::string* const tag = header_of(response, "ETag")) {
    response.set_header("ETag", packed_tag(*tag));
  }
}

bool is_read(const HttpRequest& request) {
  return request.method == "GET" || request.method == "HEAD";
}

void tag(const HttpRequest& request, HttpResponse& response) {
  if (!is_read(request) || response.status != 200 || response.stream) return;
  if (!response.body && !response.file) return;
  const std::string* const policy = header_of(response, "Cache-Control");
  if (policy == nullptr) {
    response.set_header("Cache-Control", "no-cache");
  } else if (*policy == "no-store") {
    return;
  }
  bool is_had = has_any(request);
  if (header_of(response, "ETag") == nullptr) {
    if (!response.body) return;
    const std::string tag = entity_tag(*response.body);
    response.set_header("ETag", tag);
    is_had = is_had || has_already(request, tag);
  }
  if (!is_had) return;
  // "*" names no tag: it is that of what would have been sent.
  if (has_any(request) && is_worth_packing(request, response)) set_packed_tag(response);
  response.status = 304;
  response.body = nullptr;
  response.file = nullptr;
  response.reserved = nullptr;
  std::erase_if(response.headers, [](const NameValue& h) { return h.first == "Content-Encoding"; });
}

// A 304 has the tag and the Vary of the reply that it stands for (RFC 9110, section 15.4.5), or a
// cache would not know which of its replies is still good, nor for whom.
void finish_not_modified(const HttpRequest& request, HttpResponse& response) {
  // From the reply's type, `pack` knows whether it varies. Without one it may.
  if (response.content_type.empty()) add_to_list(response, "Vary", "Accept-Encoding");
  response.content_type.clear();
  const std::string* const tag = header_of(response, "ETag");
  if (tag == nullptr || !is_listed(request, packed_tag(*tag))) return;
  // Of who has both, it is the one that would have been sent.
  if (!is_listed(request, *tag) || admits_gzip(request)) set_packed_tag(response);
}

bool is_lower_hex(std::string_view text) {
  return text.find_first_not_of("0123456789abcdef") == text.npos;
}

}  // namespace

bool admits_gzip(const HttpRequest& request) {
  const std::string* const accepted = request.header("Accept-Encoding");
  return accepted != nullptr && admits_gzip(*accepted);
}

void pack(const HttpRequest& request, HttpResponse& response, Poll* poll) {
  if (!is_text(response.content_type) || response.stream) return;
  // What is small now may be large another time.
  add_to_list(response, "Vary", "Accept-Encoding");
  if (!is_worth_packing(request, response)) return;
  response.body = std::make_shared<const std::string>(gzip(*response.body, poll));
  response.set_header("Content-Encoding", "gzip");
  set_packed_tag(response);
}

void finish_reply(const HttpRequest& request, HttpResponse& response) {
  if (response.status >= 400) response.set_header("Cache-Control", "no-store");
  tag(request, response);
  // What only its reader may keep is not to be shown with another token.
  const std::string* const policy = header_of(response, "Cache-Control");
  if (policy != nullptr && policy->starts_with("private")) {
    add_to_list(response, "Vary", "Authorization");
  }
  pack(request, response, nullptr);
  if (response.status == 304) finish_not_modified(request, response);
  response.set_header("X-Content-Type-Options", "nosniff");
  if (const std::string_view trace = trace_of(request); !trace.empty()) {
    response.set_header("traceparent", std::string(trace));
  }
}

void add_timing(const StageTimes& times, HttpResponse& response) {
  std::string text;
  for (std::size_t i = 0; i < kStageNames.size(); ++i) {
    const double seconds = times.of(static_cast<Stage>(i)).count();
    if (seconds <= 0) continue;
    char number[32];
    std::snprintf(number, sizeof number, "%.3f", 1000 * seconds);
    text += text.empty() ? "" : ", ";
    text += kStageNames[i];
    text += ";dur=";
    text += number;
  }
  if (!text.empty()) response.set_header("Server-Timing", std::move(text));
}

std::string_view trace_of(const HttpRequest& request) {
  const std::string* const header = request.header("traceparent");
  if (header == nullptr) return {};
  // version-trace-parent-flags, such as 00-<32>-<16>-01; ids of zeros are none.
  const std::string_view text = *header;
  constexpr std::size_t kLength = 55;
  const auto zero = [](std::string_view id) { return id.find_first_not_of('0') == id.npos; };
  if (text.size() != kLength || text[2] != '-' || text[35] != '-' || text[52] != '-') return {};
  const std::string_view trace = text.substr(3, 32);
  const std::string_view parent = text.substr(36, 16);
  if (!is_lower_hex(text.substr(0, 2)) || text.substr(0, 2) == "ff" || !is_lower_hex(trace) ||
      !is_lower_hex(parent) || !is_lower_hex(text.substr(53)) || zero(trace) || zero(parent)) {
    return {};
  }
  return text;
}

}  // namespace geodesic::server
