// gzip for replies in JSON.
#pragma once

#include <string>
#include <string_view>

#include "core/base/cancel.h"

namespace geodesic::server {

// Whether an Accept-Encoding header admits gzip: by name or by `*`, and not with
// q=0 (RFC 9110, section 12.5.3). The most specific entry decides.
[[nodiscard]] bool admits_gzip(std::string_view accept_encoding);

// At zlib's fastest level: numbers in JSON shrink to half, at 100 MB a second.
// Without an end if the poll, where there is one, says to stop.
[[nodiscard]] std::string gzip(std::string_view bytes, Poll* poll = nullptr);

}  // namespace geodesic::server
