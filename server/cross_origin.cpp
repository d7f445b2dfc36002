#include "server/cross_origin.h"

#include <algorithm>

#include "server/http_head.h"

namespace geodesic::server {
namespace {

// A fixed list: what the browser asks for is not echoed.
constexpr const char* kRequestHeaders =
    "Accept, Authorization, Content-Type, If-None-Match, Prefer, X-Request-Id, traceparent, "
    "tracestate";
constexpr const char* kMethods = "GET, HEAD, POST, PUT, DELETE";
constexpr const char* kReplyHeaders =
    "Allow, Content-Encoding, ETag, Geo-Cache, Geo-Dtype, Geo-Length, Geo-Max, Geo-Shape, "
    "Location, Preference-Applied, Retry-After, Server-Timing, WWW-Authenticate, X-Request-Id, "
    "traceparent";

}  // namespace

CrossOrigin::CrossOrigin(std::string_view origins) : any_(origins == "*") {
  while (!any_ && !origins.empty()) {
    const std::size_t comma = origins.find(',');
    std::string_view origin = origins.substr(0, comma);
    origins = comma == origins.npos ? std::string_view() : origins.substr(comma + 1);
    while (origin.starts_with(' ')) origin.remove_prefix(1);
    while (origin.ends_with(' ')) origin.remove_suffix(1);
    if (!origin.empty()) origins_.emplace_back(origin);
  }
}

bool CrossOrigin::is_preflight(const HttpRequest& request) {
  return request.method == "OPTIONS" && request.header("Origin") != nullptr &&
         request.header("Access-Control-Request-Method") != nullptr;
}

std::string_view CrossOrigin::allowed(const HttpRequest& request) const {
  if (any_) return "*";
  const std::string* const origin = request.header("Origin");
  if (origin == nullptr) return {};
  const auto found = std::find(origins_.begin(), origins_.end(), *origin);
  return found == origins_.end() ? std::string_view() : *found;
}

HttpResponse CrossOrigin::answer_preflight(const HttpRequest& request) const {
  HttpResponse response;
  response.status = 204;
  response.route = "preflight";
  allow(request, response);
  if (!allowed(request).empty()) {
    response.set_header("Access-Control-Allow-Methods", kMethods);
    response.set_header("Access-Control-Allow-Headers", kRequestHeaders);
    response.set_header("Access-Control-Max-Age", "86400");
  }
  add_to_list(response, "Vary", "Access-Control-Request-Method");
  add_to_list(response, "Vary", "Access-Control-Request-Headers");
  return response;
}

void CrossOrigin::allow(const HttpRequest& request, HttpResponse& response) const {
  // Caches must not hand one origin's reply to another.
  if (!any_ && !origins_.empty()) add_to_list(response, "Vary", "Origin");
  const std::string_view origin = allowed(request);
  if (origin.empty()) return;
  response.set_header("Access-Control-Allow-Origin", std::string(origin));
  response.set_header("Access-Control-Expose-Headers", kReplyHeaders);
  response.set_header("Cross-Origin-Resource-Policy", "cross-origin");
  // Or a page's own clock would not show it Server-Timing.
  response.set_header("Timing-Allow-Origin", std::string(origin));
}

void add_to_list(HttpResponse& response, const std::string& header, std::string_view name) {
  for (auto& [key, value] : response.headers) {
    if (!equals_ignoring_case(key, header)) continue;
    if ((", " + value + ",").find(", " + std::string(name) + ",") == std::string::npos) {
      value += ", ";
      value += name;
    }
    return;
  }
  response.set_header(header, std::string(name));
}

}  // namespace geodesic::server
