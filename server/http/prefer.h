// The Prefer header (RFC 7240): what a client would like, and need not get.
#pragma once

#include <string_view>

#include "server/http/message.h"

namespace geodesic::server {

// Whether the request has a preference of that name (in lower case) that stands for
// itself, such as `respond-async`: without a value, or an empty one. Whatever else a
// preference says, in whatever case, counts for nothing.
[[nodiscard]] bool prefers(const HttpRequest& request, std::string_view name);

}  // namespace geodesic::server
