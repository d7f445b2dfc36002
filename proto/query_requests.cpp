#include "proto/query_requests.h"

#include <algorithm>
#include <utility>

namespace geodesic::proto {
namespace {

Result<Method> method_of(Parameters& parameters) {
  const auto name = parameters.text("method");
  if (!name) return fail(name.error());
  return find_method(name->value_or("wavefront"));
}

// Only a source can have an offset; anywhere else it would be ignored silently.
Result<void> check_no_offset(const std::vector<PointRequest>& points) {
  for (const PointRequest& point : points) {
    if (point.offset != 0) {
      return fail(ErrorCode::value_out_of_range, "only sources can have an offset",
                  point.parameter + ".offset");
    }
  }
  return {};
}

Result<void> check_count(const std::vector<PointRequest>& points, std::size_t most,
                         const char* parameter) {
  if (points.size() <= most) return {};
  return fail_limit(ErrorCode::too_large, "too many points in one request", most, points.size(),
                    parameter);
}

// Whether one entry of an Accept header admits a media type. Quality values are
// read only as far as q=0, which forbids.
bool admits(std::string_view accept, std::string_view type) {
  const std::string_view family = type.substr(0, type.find('/'));
  while (!accept.empty()) {
    const std::size_t comma = accept.find(',');
    std::string_view entry = accept.substr(0, comma);
    accept = comma == std::string_view::npos ? "" : accept.substr(comma + 1);
    const std::size_t semicolon = entry.find(';');
    std::string_view parameters = semicolon == entry.npos ? "" : entry.substr(semicolon);
    entry = entry.substr(0, semicolon);
    const auto trim = [](std::string_view& text) {
      while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
      while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    };
    trim(entry);
    const bool named = entry == "*/*" || entry == type ||
                       (entry.ends_with("/*") && entry.substr(0, entry.size() - 2) == family);
    const bool forbidden = parameters.find("q=0") != parameters.npos &&
                           parameters.find_first_of("123456789") == parameters.npos;
    if (named && !forbidden) return true;
  }
  return false;
}

}  // namespace

Result<ReplyFormat> parse_format(Parameters& parameters, const std::string* accept) {
  ReplyFormat reply;
  const auto precision = parameters.whole("precision");
  if (!precision) return fail(precision.error());
  if (*precision) {
    if (**precision < 1 || **precision > 17) {
      return fail(ErrorCode::value_out_of_range, "precision is a number of digits from 1 to 17",
                  "precision");
    }
    reply.precision = static_cast<int>(**precision);
  }
  const auto format = parameters.text("format");
  if (!format) return fail(format.error());
  if (*format) {
    if (**format == "json") return reply;
    if (**format == "f32" || **format == "f64") {
      reply.format = **format == "f32" ? Format::f32 : Format::f64;
      return reply;
    }
    return fail(ErrorCode::not_acceptable, "no such format; there are: json, f32, f64", "format");
  }
  if (accept == nullptr || accept->empty() || admits(*accept, "application/json")) return reply;
  if (admits(*accept, "application/octet-stream")) {
    reply.format = Format::f32;
    return reply;
  }
  return fail(ErrorCode::not_acceptable,
              "offered are application/json and application/octet-stream", "Accept");
}

Result<DistanceRequest> parse_distance_request(Parameters& parameters) {
  DistanceRequest request;
  auto from = parameters.points("from");
  if (!from) return fail(std::move(from.error()));
  if (from->empty()) return fail(ErrorCode::bad_syntax, "this parameter is missing", "from");
  if (auto few = check_count(*from, kMaxSources, "from"); !few) return fail(std::move(few.error()));
  request.from = std::move(*from);
  auto at = parameters.points("at");
  if (!at) return fail(std::move(at.error()));
  if (auto few = check_count(*at, kMaxPoints, "at"); !few) return fail(std::move(few.error()));
  request.at = std::move(*at);
  if (auto plain = check_no_offset(request.at); !plain) return fail(std::move(plain.error()));
  const auto method = method_of(parameters);
  if (!method) return fail(method.error());
  request.method = *method;
  const auto max = parameters.number("max");
  if (!max) return fail(max.error());
  if (*max && !(**max >= 0)) {
    return fail(ErrorCode::value_out_of_range, "a distance is not negative", "max");
  }
  request.max = *max;
  if (auto known = parameters.check_all_known(); !known) return fail(std::move(known.error()));
  return request;
}

Result<PathRequest> parse_path_request(Parameters& parameters) {
  auto from = parameters.point("from");
  if (!from) return fail(std::move(from.error()));
  auto to = parameters.point("to");
  if (!to) return fail(std::move(to.error()));
  if (auto plain = check_no_offset({*from, *to}); !plain) return fail(std::move(plain.error()));
  const auto method = method_of(parameters);
  if (!method) return fail(method.error());
  const auto refine = parameters.text("refine");
  if (!refine) return fail(refine.error());
  if (refine->value_or("none") != "none") {
    return fail(ErrorCode::unsupported, "refine takes: none", "refine");
  }
  if (auto known = parameters.check_all_known(); !known) return fail(std::move(known.error()));
  return PathRequest{std::move(*from), std::move(*to), *method};
}

Result<NearestRequest> parse_nearest_request(Parameters& parameters) {
  auto points = parameters.points("point");
  if (!points) return fail(std::move(points.error()));
  if (points->empty()) return fail(ErrorCode::bad_syntax, "this parameter is missing", "point");
  if (auto few = check_count(*points, kMaxPoints, "point"); !few) {
    return fail(std::move(few.error()));
  }
  if (auto plain = check_no_offset(*points); !plain) return fail(std::move(plain.error()));
  if (auto known = parameters.check_all_known(); !known) return fail(std::move(known.error()));
  return NearestRequest{std::move(*points)};
}

}  // namespace geodesic::proto
