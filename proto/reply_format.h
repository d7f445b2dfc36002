// The format of a reply, by `format=` or by the Accept header.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/error.h"
#include "proto/parameters.h"

namespace geodesic::proto {

enum class Format : std::uint8_t { json, f32, f64 };

struct ReplyFormat {
  Format format = Format::json;
  int precision = 0;  // significant digits in JSON; 0: as many as the value has
};

inline constexpr Format kJsonOnly[] = {Format::json};
inline constexpr Format kJsonOrArray[] = {Format::json, Format::f32, Format::f64};

// From `format=` and `precision=`, else from an Accept header (null: none), among
// those that the query offers. Errors: not_acceptable (naming what decided),
// bad_syntax, value_out_of_range.
[[nodiscard]] Result<ReplyFormat> parse_format(Parameters& parameters, const std::string* accept,
                                               std::span<const Format> offered);

}  // namespace geodesic::proto
