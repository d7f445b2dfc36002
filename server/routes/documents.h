// Documents that are part of the program: the API's contract and the page that shows
// it. The page loads nothing from anywhere else.
#pragma once

#include <optional>

#include "server/http/message.h"

namespace geodesic::server {

// The reply to the GET of a path; nothing where there is no document. Browsers, which name
// text/html among what they accept, get the YAML as plain text: they would save it otherwise.
[[nodiscard]] std::optional<HttpResponse> find_document(const HttpRequest& request);

}  // namespace geodesic::server
