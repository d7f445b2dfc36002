// Whose request it is where proxies stand between.
#pragma once

#include <string>

#include "server/base/address_ranges.h"
#include "server/http/head.h"

namespace geodesic::server {

// The address of the client that asked `peer` to pass this request on: in X-Forwarded-For, to
// which each proxy adds who asked it, the last address that is none of the trusted proxies'. What
// stands before it may be made up. `peer` itself if that is no trusted proxy, or where nothing
// readable was added. If all addresses are trusted ones: the first.
[[nodiscard]] std::string forwarded_for(const AddressRanges& trusted, const HttpHead& head,
                                        const std::string& peer);

}  // namespace geodesic::server
