// What a job is called: 16 hexadecimal digits for balancers to go by, and 32 random ones.
#pragma once

#include <cstddef>
#include <string_view>

#include "core/base/error.h"
#include "server/base/service_codes.h"

namespace geodesic::server {

inline constexpr std::size_t kRoutingDigits = 16;

[[nodiscard]] constexpr bool is_hexadecimal(std::string_view text) {
  return text.find_first_not_of("0123456789abcdef") == text.npos;
}

[[nodiscard]] constexpr bool is_job_id(std::string_view id) {
  return id.size() == kRoutingDigits + 32 && is_hexadecimal(id);
}

[[nodiscard]] inline tl::unexpected<Error> fail_unknown_job() {
  return fail(ServiceCode::job_unknown, "no job of this id is kept");
}

}  // namespace geodesic::server
