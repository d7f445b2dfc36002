// What the edge itself says in the head of a reply, whatever the handler and cpp-httplib say there:
// the reason behind a status, the date, and which headers are its own.
#pragma once

#include <string>
#include <string_view>

namespace geodesic::server {

// cpp-httplib's status line for a status that it has no words for, from behind the number …
inline constexpr std::string_view kWordless = " Internal Server Error\r\n";
// … and what stands there instead.
[[nodiscard]] std::string_view reason_of(int status);

// Whether the edge sets the header itself, so that a handler's is left out.
[[nodiscard]] bool is_of_edge(std::string_view name);

// The text itself, or `spare` with what there is beside controls.
[[nodiscard]] const std::string& without_controls(const std::string& text, std::string& spare);

// The value of `Date` now, written once a second. Until the thread's next call.
[[nodiscard]] const std::string& http_date();

}  // namespace geodesic::server
