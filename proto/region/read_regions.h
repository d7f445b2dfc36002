// Regions out of the parameters of a query.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "proto/region/region.h"
#include "proto/wire/parameters.h"

namespace geodesic::proto {

// `within` and `forbid`, each one shape or several, and `walls`, one or several. Errors:
// bad_syntax, value_out_of_range, unknown_parameter, and too_large (over one of query_limits.h),
// naming the one at fault such as "forbid[2].sphere.radius".
[[nodiscard]] Result<Regions> read_regions(Parameters& parameters);

// One shape as a URL has it, and as JSON has it. `parameter` is what errors name.
[[nodiscard]] Result<Shape> parse_shape(std::string_view text, std::string parameter);
[[nodiscard]] Result<Shape> parse_json_shape(const nlohmann::json& value, std::string parameter);

// One wall likewise.
[[nodiscard]] Result<Wall> parse_wall(std::string_view text, std::string parameter);
[[nodiscard]] Result<Wall> parse_json_wall(const nlohmann::json& value, std::string parameter);
// The points of a line, POINT;POINT. `parameter`: of the line, such as "walls[2].points".
[[nodiscard]] Result<std::vector<PointRequest>> parse_line(std::string_view text,
                                                           const std::string& parameter);

}  // namespace geodesic::proto
