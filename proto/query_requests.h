// What each query asks, as values: parsed and within its domain, but not yet
// held against a mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "proto/methods.h"
#include "proto/parameters.h"
#include "proto/point_request.h"

namespace geodesic::proto {

// Each source has a wave of its own; each point is looked up and answered.
inline constexpr std::size_t kMaxSources = 1000;
inline constexpr std::size_t kMaxPoints = 100'000;

enum class Format : std::uint8_t { json, f32, f64 };

struct ReplyFormat {
  Format format = Format::json;
  int precision = 0;  // significant digits in JSON; 0: as many as the value has
};

// From `format=` and `precision=`, else from an Accept header (null: none).
// Errors: not_acceptable, bad_syntax, value_out_of_range.
[[nodiscard]] Result<ReplyFormat> parse_format(Parameters& parameters, const std::string* accept);

struct DistanceRequest {
  std::vector<PointRequest> from;
  std::vector<PointRequest> at;  // empty: all source vertices
  Method method = Method::wavefront;
  std::optional<double> max;  // mesh units
};

struct PathRequest {
  PointRequest from;
  PointRequest to;
  Method method = Method::wavefront;
};

struct NearestRequest {
  std::vector<PointRequest> points;
};

// Errors: bad_syntax, unknown_parameter, value_out_of_range, method_unknown, unsupported,
// too_large (more points than the limits above).
[[nodiscard]] Result<DistanceRequest> parse_distance_request(Parameters& parameters);
[[nodiscard]] Result<PathRequest> parse_path_request(Parameters& parameters);
[[nodiscard]] Result<NearestRequest> parse_nearest_request(Parameters& parameters);

}  // namespace geodesic::proto
