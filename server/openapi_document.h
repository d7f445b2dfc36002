// proto/openapi.yaml, as part of the program.
#pragma once

#include <string_view>

namespace geodesic::server {

[[nodiscard]] std::string_view openapi_document();

}  // namespace geodesic::server
