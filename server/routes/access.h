// Who may do what: finds the token of a request and compares its scopes with what
// the request needs.
//
//   nothing          /, /docs/…, the API's description, /livez, /readyz, GET /v1/methods,
//                    OPTIONS
//   read             any other GET or HEAD, and queries by POST
//   upload           POST /v1/meshes, PUT, PATCH
//   read or upload   /v1/jobs/…: of either
//   admin            DELETE of anything else, /metrics, /debug/…
//
// Paths that nobody knows need `read` (or, by their method, more): a route that is
// added and forgotten here is closed rather than open.
//
// A token comes in the Authorization header and nowhere else: URLs end up in logs,
// histories and Referer headers. What a request brought there is never repeated, not
// in an answer and not in the log.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/base/current.h"
#include "server/config/tokens.h"
#include "server/http/message.h"

namespace geodesic::server {

// The scopes any one of which a request needs; none: it is open to everybody.
// `path` is percent-decoded.
[[nodiscard]] Scopes needed_scopes(std::string_view method, std::string_view path);

// Thread-safe.
class Access {
 public:
  using Clock = std::function<std::chrono::system_clock::time_point()>;

  // Without tokens everybody may do everything.
  explicit Access(Clock now = std::chrono::system_clock::now)
      : now_(std::move(now)), tokens_(std::nullopt) {}

  // For requests to come; nothing: no token is asked for any more.
  void set_tokens(std::optional<Tokens> tokens) { tokens_.set(std::move(tokens)); }

  // Whether tokens are asked for: replies are then one client's, not every cache's.
  [[nodiscard]] bool is_on() const { return tokens_->has_value(); }
  // Who may keep what needs a token, for Cache-Control: without tokens, any cache.
  [[nodiscard]] std::string audience() const { return is_on() ? "private" : "public"; }

  // Nothing if the request may go on: a token that was asked for is then its
  // caller's client, whose turn in queues it takes from wherever it comes. Otherwise
  // the reply, a 401 or 403.
  [[nodiscard]] std::optional<HttpResponse> check(HttpRequest& request) const;

  // Whether `check` would let it go on; to be asked before its body is received. If so, its
  // caller's client is set as by `check`.
  [[nodiscard]] bool admits(HttpRequest& request) const;

 private:
  enum class Outcome : std::uint8_t { allowed, absent, invalid, expired, lacking };
  struct Verdict {
    Outcome outcome = Outcome::allowed;
    Scopes needed;
    std::string name;  // of the token; empty if none was asked for, or it is unknown
  };
  [[nodiscard]] Verdict judge(const HttpRequest& request) const;
  static void name_client(const Verdict& verdict, HttpRequest& request);

  const Clock now_;
  Current<std::optional<Tokens>> tokens_;
};

}  // namespace geodesic::server
