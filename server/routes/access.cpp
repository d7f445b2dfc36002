#include "server/routes/access.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <string>

#include "server/base/service_codes.h"
#include "server/http/head.h"
#include "server/http/request_log.h"

namespace geodesic::server {

namespace {

// What the log line of a refused request names instead of its target: that may hold
// a token that somebody put into the URL.
constexpr std::string_view kRefusedRoute = "(refused)";

// The token of an Authorization header; nothing if there is no such header or it is
// of another scheme. Empty where there should be one and there is none that can be.
std::optional<std::string_view> bearer_token(const HttpRequest& request) {
  const std::string* sent = nullptr;
  for (const auto& [name, value] : request.headers) {
    if (!equals_ignoring_case(name, "Authorization")) continue;
    if (sent != nullptr) return std::string_view();  // two: which one counts is anybody's guess
    sent = &value;
  }
  if (sent == nullptr) return {};
  constexpr std::string_view kScheme = "Bearer";
  const std::string_view text = *sent;
  if (!equals_ignoring_case(text.substr(0, kScheme.size()), kScheme)) return {};
  if (text.size() > kScheme.size() && text[kScheme.size()] != ' ') return {};
  const std::size_t begin = text.find_first_not_of(' ', kScheme.size());
  if (begin == std::string_view::npos) return std::string_view();
  return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

bool is_below(std::string_view path, std::string_view folder) {
  return path == folder || (path.starts_with(folder) && path[folder.size()] == '/');
}

}  // namespace

Scopes needed_scopes(std::string_view method, std::string_view path) {
  if (method == "OPTIONS") return {};
  const bool gets = method == "GET" || method == "HEAD";
  constexpr std::array<std::string_view, 6> kOpen{"/",      "/openapi.json", "/openapi.yaml",
                                                  "/livez", "/readyz",       "/v1/methods"};
  if (gets && (std::find(kOpen.begin(), kOpen.end(), path) != kOpen.end() ||
               is_below(path, "/docs") || is_below(path, "/assets"))) {
    return {};
  }
  if (is_below(path, "/metrics") || is_below(path, "/debug")) return Scope::admin;
  if (is_below(path, "/v1/jobs")) return Scope::read | Scope::upload;
  if (method == "DELETE") return Scope::admin;
  if (method == "PUT" || method == "PATCH" || (method == "POST" && path == "/v1/meshes"))
    return Scope::upload;
  return Scope::read;
}

auto Access::judge(const HttpRequest& request) const -> Verdict {
  const auto tokens = tokens_.get();
  Verdict verdict;
  if (!*tokens) return verdict;
  // The base path by itself leads to the start page.
  const bool is_base = !request.base_path.empty() && request.path == request.base_path;
  verdict.needed = needed_scopes(request.method, is_base ? "/" : request.path);
  if (verdict.needed.empty()) return verdict;
  const auto sent = bearer_token(request);
  if (!sent) {
    verdict.outcome = Outcome::absent;
    return verdict;
  }
  const Token* const token = (*tokens)->find(*sent);
  if (token == nullptr) {
    verdict.outcome = Outcome::invalid;
    return verdict;
  }
  verdict.name = token->name;
  if (token->expires && now_() >= *token->expires) {
    verdict.outcome = Outcome::expired;
  } else if (!token->scopes.satisfy(verdict.needed)) {
    verdict.outcome = Outcome::lacking;
  }
  return verdict;
}

void Access::name_client(const Verdict& verdict, HttpRequest& request) {
  // No address looks like this, so that nobody can take another's turns.
  if (!verdict.name.empty()) request.caller.client = "token:" + verdict.name;
}

bool Access::admits(HttpRequest& request) const {
  const Verdict verdict = judge(request);
  if (verdict.outcome != Outcome::allowed) return false;
  name_client(verdict, request);
  return true;
}

std::optional<HttpResponse> Access::check(HttpRequest& request) const {
  const Verdict verdict = judge(request);
  Error error{ServiceCode::unauthorized, {}, {}, {}, {}};
  std::string challenge = "Bearer realm=\"geodesicd\"";
  switch (verdict.outcome) {
    case Outcome::allowed:
      name_client(verdict, request);
      return {};
    case Outcome::absent:
      error.detail = "this needs a token, in the header 'Authorization: Bearer TOKEN'";
      break;
    case Outcome::invalid:
    case Outcome::expired:
      // One answer for both: an expired token proves nothing about who sends it.
      error.detail = "the token is not valid, or not any more";
      challenge += ", error=\"invalid_token\"";
      break;
    case Outcome::lacking: {
      // Of several that would do, the first.
      std::string scope = format_scopes(verdict.needed);
      scope = scope.substr(0, scope.find(','));
      error.code = ServiceCode::forbidden;
      error.detail = "the token lacks the scope '" + scope + "'";
      challenge += ", error=\"insufficient_scope\", scope=\"" + scope + "\"";
      break;
    }
  }
  spdlog::info("{} refused {} {}: {}{}", request.id, for_log(request.method), for_log(request.path),
               error.detail, verdict.name.empty() ? "" : " (token " + verdict.name + ")");
  HttpResponse response = HttpResponse::problem(error, request);
  response.set_header("WWW-Authenticate", std::move(challenge));
  response.route = kRefusedRoute;
  return response;
}

}  // namespace geodesic::server
