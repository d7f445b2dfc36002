// One log line a request, and the id by which a client's report finds it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/http/message.h"

namespace geodesic::server {

// Whether a client's X-Request-Id may be echoed and logged: [A-Za-z0-9._-]{1,64}.
[[nodiscard]] bool is_sane_request_id(std::string_view id);

// 16 hexadecimal digits at random.
[[nodiscard]] std::string make_request_id();

// Text from outside as a field of a log line: at most 200 bytes of it, and
// unable to break out of the field or the line (controls, spaces, quotes and
// bytes beyond ASCII become \xNN). Never empty.
[[nodiscard]] std::string for_log(std::string_view text);

// id, peer, method, route, status, bytes sent, milliseconds; at level info.
// `route` empty: the target.
void log_request(const HttpRequest& request, std::string_view route, int status,
                 std::uint64_t bytes_sent, double milliseconds, bool all_sent);

}  // namespace geodesic::server
