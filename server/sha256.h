// SHA-256 of bytes, the address of a mesh.
#pragma once

#include <string>
#include <string_view>

namespace geodesic::server {

// 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256_hex(std::string_view bytes);

}  // namespace geodesic::server
