// SHA-256 of bytes, the address of a mesh.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace geodesic::server {

// 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256_hex(std::string_view bytes);
// The same, or nothing once `stop`, asked every few milliseconds, says so.
[[nodiscard]] std::optional<std::string> sha256_hex(std::string_view bytes,
                                                    const std::function<bool()>& stop);

}  // namespace geodesic::server
