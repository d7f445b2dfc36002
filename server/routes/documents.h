// Documents that are part of the program: the API's contract and the page that shows
// it. The page loads nothing from anywhere else.
#pragma once

#include <optional>

#include "server/http/message.h"

namespace geodesic::server {

// The reply to the GET of a path; nothing where there is no document. Browsers, which name
// text/html among what they accept, get the YAML as plain text: they would save it otherwise.
// The contract names the server by the path that requests have to begin with.
[[nodiscard]] std::optional<HttpResponse> find_document(const HttpRequest& request);

// A page with status 404 for a browser that asks for a path below /docs/; nothing for others, who
// get a problem as everywhere.
[[nodiscard]] std::optional<HttpResponse> missing_document(const HttpRequest& request);

}  // namespace geodesic::server
