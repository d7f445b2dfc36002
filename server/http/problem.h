// What a client sees of an error: the one table from codes to HTTP status and
// title, and the body of `application/problem+json` (RFC 9457).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "server/http/message.h"

namespace geodesic::server {

inline constexpr std::string_view kProblemMediaType = "application/problem+json";

// Every code that a client may meet, in the order of the contract.
[[nodiscard]] std::vector<ErrorCode> all_error_codes();

// The HTTP status of a code, such as 404 for `mesh_unknown`.
[[nodiscard]] int http_status(ErrorCode code);

// A few words that are the same for every error of that code.
[[nodiscard]] std::string_view problem_title(ErrorCode code);

// Seconds after which a client should try again; 0: no `Retry-After`.
[[nodiscard]] int retry_after_seconds(ErrorCode code);

// {"type":"/docs/errors/#mesh_unknown","title","status","detail","instance","code",
// "request_id"} and, where the error has them, "parameter", "limit", "actual".
// The type begins with the request's base path. `instance` is the raw request target, unless it is
// given. Bytes that are not UTF-8 are replaced. `status` overrides the code's own where one code
// serves several (431).
[[nodiscard]] std::string to_problem_json(const Error& error, const HttpRequest& request,
                                          int status = 0, std::string_view instance = {});

}  // namespace geodesic::server
