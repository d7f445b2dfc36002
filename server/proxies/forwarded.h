// Whose request it is where proxies stand between and say so in a header.
#pragma once

#include <cstdint>
#include <string>

#include "server/base/address_ranges.h"
#include "server/http/head.h"

namespace geodesic::server {

// The header that the proxies write. Only this one is read: the other one may come from the client
// and pass through them untouched.
enum class ForwardedHeader : std::uint8_t {
  x_forwarded_for,  // X-Forwarded-For: addresses with commas between them
  forwarded,        // Forwarded: for="address:port";… (RFC 7239)
};

// The address of the client that asked `peer` to pass this request on: in the header, to which each
// proxy adds who asked it, the last address that is none of the trusted proxies'. What stands
// before it may be made up. `peer` itself if that is no trusted proxy, or where nothing readable
// was added. If all addresses are trusted ones: the first, or the 64th from the end.
[[nodiscard]] std::string forwarded_for(const AddressRanges& trusted, ForwardedHeader written,
                                        const HttpHead& head, const std::string& peer);

}  // namespace geodesic::server
