// Files that are part of the program.
#pragma once

#include <string_view>

namespace geodesic::server {

[[nodiscard]] std::string_view openapi_yaml();  // proto/openapi.yaml
[[nodiscard]] std::string_view start_page();    // clients/web/index.html

}  // namespace geodesic::server
