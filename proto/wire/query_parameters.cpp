#include "proto/wire/query_parameters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "proto/wire/input_codes.h"
#include "proto/wire/methods.h"
#include "proto/wire/number.h"
#include "proto/wire/query_limits.h"

namespace geodesic::proto {
namespace {

bool serves(const MethodParameter& parameter, Purpose purpose) {
  return parameter.serves == Serves::all ||
         (parameter.serves == Serves::paths) == (purpose == Purpose::paths);
}

// The place of the given word among the choices.
Result<double> read_choice(Parameters& parameters, const MethodParameter& parameter) {
  const auto given = parameters.text(parameter.name);
  if (!given) return fail(given.error());
  if (!*given) return parameter.standard;
  const auto it = std::find(parameter.choices.begin(), parameter.choices.end(), **given);
  if (it == parameter.choices.end()) {
    std::string choices;
    for (const std::string_view choice : parameter.choices) {
      choices += (choices.empty() ? "" : ", ") + std::string(choice);
    }
    return fail(ErrorCode::value_out_of_range, "this is none of the choices: " + choices,
                std::string(parameter.name));
  }
  return static_cast<double>(it - parameter.choices.begin());
}

// Refuses what only other methods take, and says which ones do.
Result<void> check_parameters_of_others(const Parameters& parameters, Purpose purpose,
                                        Method chosen) {
  for (const MethodInfo& other : all_methods()) {
    for (const MethodParameter& parameter : other.parameters) {
      const auto is_of = [&](const MethodInfo& method) {
        return std::any_of(
            method.parameters.begin(), method.parameters.end(),
            [&](const auto& own) { return own.name == parameter.name && serves(own, purpose); });
      };
      if (parameters.count(parameter.name) == 0 || is_of(info_of(chosen))) continue;
      if (!serves(parameter, purpose)) continue;
      return fail(InputCode::unknown_parameter,
                  "method=" + std::string(name_of(chosen)) +
                      " does not take this, method=" + std::string(other.name) + " does",
                  std::string(parameter.name));
    }
  }
  return {};
}

// All together; one alone has been held against the same limit.
Result<void> check_curves(const std::vector<PointRequest>& sources, const char* parameter) {
  std::size_t points = 0;
  for (const PointRequest& source : sources) {
    if (const auto* curve = std::get_if<std::shared_ptr<const CurveRequest>>(&source.where)) {
      points += (*curve)->points.size();
    }
  }
  if (points <= kMaxCurvePoints) return {};
  return fail_limit(
      ErrorCode::too_large,
      "too many points in the curves of one request; ask from fewer curves at once, or "
      "leave points out where a curve is straight",
      kMaxCurvePoints, points, parameter);
}

Result<void> read_any_sources(Parameters& parameters, std::size_t most,
                              std::vector<PointRequest>& sources) {
  // Counted before they are taken apart.
  if (auto few = check_count(parameters.count("from"), most, "from"); !few) return few;
  auto from = parameters.sources("from");
  if (!from) return fail(std::move(from.error()));
  sources = std::move(*from);
  return check_curves(sources, "from");
}

}  // namespace

bool asks_for_costs(const Parameters& parameters) {
  constexpr std::array<std::string_view, 5> kNames{"weights", "face_weights", "weight_attribute",
                                                   "slope", "steepest"};
  return std::any_of(kNames.begin(), kNames.end(),
                     [&](std::string_view name) { return parameters.count(name) > 0; });
}

Result<void> read_method(Parameters& parameters, Purpose purpose, MethodChoice& choice) {
  const auto name = parameters.text("method");
  if (!name) return fail(name.error());
  const bool has_costs = asks_for_costs(parameters);
  const Method standard = has_costs ? Method::steiner : kDefaultMethod;
  const auto method = find_method(name->value_or(std::string(name_of(standard))));
  if (!method) return fail(method.error());
  if (has_costs && *method != Method::steiner) {
    return fail(ErrorCode::value_out_of_range,
                "weights and slopes are for method=steiner alone, which needs not be named",
                "method");
  }
  choice.which = *method;
  for (const MethodParameter& parameter : info_of(*method).parameters) {
    if (!serves(parameter, purpose)) continue;
    double value = parameter.standard;
    if (!parameter.choices.empty()) {
      const auto given = read_choice(parameters, parameter);
      if (!given) return fail(given.error());
      value = *given;
    } else if (parameter.whole) {
      const auto given = parameters.whole(parameter.name);
      if (!given) return fail(given.error());
      if (*given) value = static_cast<double>(**given);
    } else {
      const auto given = parameters.number(parameter.name);
      if (!given) return fail(given.error());
      value = given->value_or(value);
    }
    if (std::isnan(value)) continue;  // not given, and nothing instead
    if (!(value >= parameter.minimum && value <= parameter.maximum)) {
      std::string detail = "this method takes from ";
      append_number(detail, parameter.minimum);
      detail += " to ";
      append_number(detail, parameter.maximum);
      return fail(ErrorCode::value_out_of_range, std::move(detail), std::string(parameter.name));
    }
    parameter.set(choice.options, value);
  }
  return check_parameters_of_others(parameters, purpose, choice.which);
}

Result<void> check_count(std::size_t count, std::size_t most, const char* parameter) {
  if (count <= most) return {};
  return fail_limit(ErrorCode::too_large, "too many in one request", most, count, parameter);
}

Result<void> missing(const char* parameter) {
  return fail(InputCode::bad_syntax, "this parameter is missing", parameter);
}

Result<void> check_no_offset(const std::vector<PointRequest>& points) {
  for (const PointRequest& point : points) {
    if (point.offset != 0) {
      return fail(ErrorCode::value_out_of_range, "only sources of a field can have an offset",
                  point.parameter + ".offset");
    }
  }
  return {};
}

Result<void> read_sources(Parameters& parameters, std::vector<PointRequest>& sources) {
  return read_any_sources(parameters, kMaxSources, sources);
}

Result<void> read_rows(Parameters& parameters, std::size_t most, std::vector<PointRequest>& rows) {
  if (auto ok = read_any_sources(parameters, most, rows); !ok) return ok;
  return check_no_offset(rows);
}

Result<void> read_columns(Parameters& parameters, std::size_t most,
                          std::vector<PointRequest>& columns) {
  if (auto few = check_count(parameters.count("to"), most, "to"); !few) return few;
  auto read = parameters.sources("to");
  if (!read) return fail(std::move(read.error()));
  columns = std::move(*read);
  if (auto few = check_curves(columns, "to"); !few) return few;
  return check_no_offset(columns);
}

Result<void> check_costs_from_points(const Parameters& parameters,
                                     const std::vector<PointRequest>& sources) {
  if (!asks_for_costs(parameters)) return {};
  for (const PointRequest& source : sources) {
    if (source.is_point()) continue;
    return fail(ErrorCode::value_out_of_range,
                "what ways cost is told from points alone, and to points", source.parameter);
  }
  return {};
}

Result<void> read_points(Parameters& parameters, const char* name, std::size_t most,
                         std::vector<PointRequest>& points) {
  if (auto few = check_count(parameters.count(name), most, name); !few) return few;
  auto read = parameters.points(name);
  if (!read) return fail(std::move(read.error()));
  points = std::move(*read);
  return check_no_offset(points);
}

Result<void> read_point(Parameters& parameters, const char* name, PointRequest& point) {
  auto read = parameters.point(name);
  if (!read) return fail(std::move(read.error()));
  point = std::move(*read);
  return check_no_offset({point});
}

Result<void> read_max(Parameters& parameters, std::optional<double>& max) {
  const auto read = parameters.number("max");
  if (!read) return fail(read.error());
  if (*read && !(**read >= 0)) {
    return fail(ErrorCode::value_out_of_range, "a distance is not negative", "max");
  }
  max = *read;
  return {};
}

}  // namespace geodesic::proto
