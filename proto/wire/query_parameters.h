// What several queries read in the same way: points, sources, the method with what it takes,
// limits. Errors of each name the parameter: bad_syntax, value_out_of_range, too_large,
// unknown_parameter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "proto/wire/parameters.h"
#include "proto/wire/point_request.h"
#include "proto/wire/requests.h"

namespace geodesic::proto {

// What a query asks of a method: parameters that only paths depend on are refused
// by the others, not ignored.
enum class Purpose : std::uint8_t { distances, paths };

[[nodiscard]] Result<void> read_method(Parameters& parameters, Purpose purpose,
                                       MethodChoice& choice);

// Whether ways are to be cheap instead of short (proto/region/read_costs.h).
[[nodiscard]] bool asks_for_costs(const Parameters& parameters);

// A number of things against what one request may have. too_large
[[nodiscard]] Result<void> check_count(std::size_t count, std::size_t most, const char* parameter);

// The error of a parameter that has to be there.
[[nodiscard]] Result<void> missing(const char* parameter);

// Only a source can have an offset; anywhere else it would be ignored silently.
[[nodiscard]] Result<void> check_no_offset(const std::vector<PointRequest>& points);

// `from`: points with offsets, curves, boundaries and faces.
[[nodiscard]] Result<void> read_sources(Parameters& parameters, std::vector<PointRequest>& sources);
// The same without offsets, at most so many.
[[nodiscard]] Result<void> read_rows(Parameters& parameters, std::size_t most,
                                     std::vector<PointRequest>& rows);
// `to`: what a table's columns are, points or lines, at most so many.
[[nodiscard]] Result<void> read_columns(Parameters& parameters, std::size_t most,
                                        std::vector<PointRequest>& columns);

// Where costs are asked for, refuses sources that are no points.
[[nodiscard]] Result<void> check_costs_from_points(const Parameters& parameters,
                                                   const std::vector<PointRequest>& sources);

// Points without offsets, at most so many.
[[nodiscard]] Result<void> read_points(Parameters& parameters, const char* name, std::size_t most,
                                       std::vector<PointRequest>& points);
[[nodiscard]] Result<void> read_point(Parameters& parameters, const char* name,
                                      PointRequest& point);

// `max`, a distance.
[[nodiscard]] Result<void> read_max(Parameters& parameters, std::optional<double>& max);

}  // namespace geodesic::proto
