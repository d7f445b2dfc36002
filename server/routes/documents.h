// Documents that are part of the program: the API's contract and the page that shows
// it. The page loads nothing from anywhere else.
#pragma once

#include <optional>
#include <string_view>

#include "server/http/message.h"

namespace geodesic::server {

// The reply to GET for a path; nothing where there is no document.
[[nodiscard]] std::optional<HttpResponse> find_document(std::string_view path);

}  // namespace geodesic::server
