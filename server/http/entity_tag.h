// Entity tags (RFC 9110, section 8.8.3): what a client's copy of a reply is known by,
// so that it can be told that nothing has changed.
#pragma once

#include <string>
#include <string_view>

#include "server/http/message.h"

namespace geodesic::server {

// A strong tag for whatever `content` identifies: a reply's bytes, or everything that
// they depend on.
[[nodiscard]] std::string entity_tag(std::string_view content);

// The weak tag of that name: for replies that mean the same and may differ in their bytes.
[[nodiscard]] std::string weak_tag(std::string_view tag);

// The tag of a reply with that tag once it is packed by gzip: other bytes.
[[nodiscard]] std::string packed_tag(std::string_view tag);

// Whether the request has the reply of that tag already, packed or not: by the list in
// If-None-Match, compared weakly.
[[nodiscard]] bool has_already(const HttpRequest& request, std::string_view tag);

// Whether the list in If-None-Match has this very tag, compared weakly.
[[nodiscard]] bool is_listed(const HttpRequest& request, std::string_view tag);

// Whether If-None-Match is "*": any reply is as good as had, but only once it is known that there
// is one (RFC 9110, section 13.2.1).
[[nodiscard]] bool has_any(const HttpRequest& request);

// 304: what the request has is still good. `tag` is that of the bare reply; `finish_reply` makes it
// that of the packed one for who has that. With the `content_type` that the reply would have had,
// `Vary` is the same as the reply's; the type is not sent.
[[nodiscard]] HttpResponse not_modified(std::string_view tag);

}  // namespace geodesic::server
