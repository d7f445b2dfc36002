// The deadline that a request asks for.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "core/base/error.h"
#include "proto/wire/parameters.h"
#include "server/base/caller.h"

namespace geodesic::server {

inline constexpr std::uint64_t kLongestDeadline = 3'600'000;  // milliseconds

// The caller, with an earlier deadline if the query asks for one: `deadline_ms` from now. Errors:
// bad_syntax, value_out_of_range.
[[nodiscard]] inline Result<Caller> with_deadline(const Caller& caller,
                                                  proto::Parameters& parameters) {
  const auto milliseconds = parameters.whole("deadline_ms");
  if (!milliseconds) return fail(milliseconds.error());
  Caller hurried = caller;
  if (!*milliseconds) return hurried;
  if (**milliseconds < 1 || **milliseconds > kLongestDeadline) {
    return fail_limit(ErrorCode::value_out_of_range, "a deadline is 1 to 3600000 milliseconds off",
                      kLongestDeadline, **milliseconds, "deadline_ms");
  }
  const auto deadline = Caller::Clock::now() + std::chrono::milliseconds(**milliseconds);
  hurried.deadline = std::min(deadline, caller.deadline.value_or(deadline));
  return hurried;
}

}  // namespace geodesic::server
