#include "server/http/cross_origin.h"

#include <algorithm>
#include <array>
#include <utility>

#include "server/base/service_codes.h"
#include "server/http/head.h"

namespace geodesic::server {
namespace {

// A fixed list: what the browser asks for is not echoed.
constexpr const char* kRequestHeaders =
    "Accept, Authorization, Content-Disposition, Content-Type, If-None-Match, Prefer, "
    "X-Request-Id, traceparent, tracestate";
constexpr std::array<std::string_view, 6> kMethods{"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE"};
constexpr const char* kReplyHeaders =
    "Allow, Content-Encoding, ETag, Geo-Cache, Geo-Dtype, Geo-Estimated, Geo-Length, Geo-Max, "
    "Geo-Rows, Geo-Shape, Geo-Warnings, Location, Preference-Applied, Retry-After, Server-Timing, "
    "WWW-Authenticate, X-Request-Id, traceparent";

// An authority without the port that a scheme has anyway.
std::string_view without_port(std::string_view authority, std::string_view port) {
  if (authority.ends_with(port)) authority.remove_suffix(port.size());
  if (authority.ends_with(':')) authority.remove_suffix(1);
  return authority;
}

// Whether a page of `origin` came from the host that `authority` names. X-Forwarded-Proto and
// its like are not asked: anybody may send them, and the host decides.
bool is_origin_of(std::string_view origin, std::string_view authority) {
  for (const auto& [scheme, port] :
       {std::pair{std::string_view("http://"), std::string_view(":80")},
        std::pair{std::string_view("https://"), std::string_view(":443")}}) {
    if (!equals_ignoring_case(origin.substr(0, scheme.size()), scheme)) continue;
    const std::string_view host = without_port(origin.substr(scheme.size()), port);
    return !host.empty() && equals_ignoring_case(host, without_port(authority, port));
  }
  return false;
}

}  // namespace

CrossOrigin::Origins::Origins(std::string_view list) : any(list == "*") {
  while (!any && !list.empty()) {
    const std::size_t comma = list.find(',');
    std::string_view origin = list.substr(0, comma);
    list = comma == list.npos ? std::string_view() : list.substr(comma + 1);
    while (origin.starts_with(' ')) origin.remove_prefix(1);
    while (origin.ends_with(' ')) origin.remove_suffix(1);
    if (!origin.empty()) named.emplace_back(origin);
  }
}

bool CrossOrigin::Origins::has(std::string_view origin) const {
  return any || std::find(named.begin(), named.end(), origin) != named.end();
}

CrossOrigin::CrossOrigin(std::string_view origins, std::string_view writers)
    : readers_(origins), writers_(writers) {}

bool CrossOrigin::changes(std::string_view method, std::string_view path) {
  if (method == "GET" || method == "HEAD" || method == "OPTIONS") return false;
  if (path.starts_with("/v1/jobs/")) return false;
  return method != "POST" || !path.starts_with("/v1/meshes/");
}

bool CrossOrigin::may_change(const HttpRequest& request) const {
  const auto sent = std::count_if(
      request.headers.begin(), request.headers.end(),
      [](const NameValue& header) { return equals_ignoring_case(header.first, "Origin"); });
  const std::string* const origin = request.header("Origin");
  if (sent > 1) return false;
  if (writers_.any || (origin != nullptr && writers_.has(*origin))) return true;
  if (origin != nullptr && *origin == "null") return false;  // anybody's: a sandbox, a file
  const bool is_own = origin == nullptr || is_origin_of(*origin, request.authority);
  const std::string* const site = request.header("Sec-Fetch-Site");
  if (site == nullptr) return is_own;
  return *site == "same-origin" || (*site == "none" && is_own);
}

HttpResponse CrossOrigin::refusal(const HttpRequest& request) {
  HttpResponse response = HttpResponse::problem(
      Error{ServiceCode::forbidden,
            "pages of other origins may not change meshes here; the server's operator can let "
            "them (--cors-write-origins)",
            "Origin",
            {},
            {}},
      request);
  response.route = "(refused)";
  return response;
}

std::optional<HttpResponse> CrossOrigin::refuse(const HttpRequest& request) const {
  if (!changes(request.method, request.path) || may_change(request)) return std::nullopt;
  return refusal(request);
}

bool CrossOrigin::is_preflight(const HttpRequest& request) {
  return request.method == "OPTIONS" && request.header("Origin") != nullptr &&
         request.header("Access-Control-Request-Method") != nullptr;
}

std::string_view CrossOrigin::allowed(const HttpRequest& request) const {
  if (readers_.any) return "*";
  const std::string* const origin = request.header("Origin");
  return origin != nullptr && readers_.has(*origin) ? std::string_view(*origin)
                                                    : std::string_view();
}

HttpResponse CrossOrigin::answer_preflight(const HttpRequest& request) const {
  const bool may_change = this->may_change(request);
  const std::string* const method = request.header("Access-Control-Request-Method");
  HttpResponse response;
  if (method != nullptr && changes(*method, request.path) && !may_change) {
    response = refusal(request);
  } else {
    response.status = 204;
  }
  response.route = "preflight";
  allow(request, response);
  if (response.status == 204 && !allowed(request).empty()) {
    std::string methods;
    for (const std::string_view each : kMethods) {
      if (!may_change && changes(each, request.path)) continue;
      methods += methods.empty() ? "" : ", ";
      methods += each;
    }
    response.set_header("Access-Control-Allow-Methods", std::move(methods));
    response.set_header("Access-Control-Allow-Headers", kRequestHeaders);
    response.set_header("Access-Control-Max-Age", "86400");
  }
  add_to_list(response, "Vary", "Access-Control-Request-Method");
  add_to_list(response, "Vary", "Access-Control-Request-Headers");
  return response;
}

void CrossOrigin::allow(const HttpRequest& request, HttpResponse& response) const {
  // Caches must not hand one origin's reply to another.
  if (!readers_.any && !readers_.named.empty()) add_to_list(response, "Vary", "Origin");
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
