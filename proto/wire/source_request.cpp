// What a field starts from, as clients write it: points, curves, boundaries, faces.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "proto/wire/input_codes.h"
#include "proto/wire/number.h"
#include "proto/wire/point_request.h"
#include "proto/wire/query_limits.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

tl::unexpected<Error> no_source(std::string detail, std::string parameter) {
  return fail(InputCode::bad_syntax, std::move(detail), std::move(parameter));
}

constexpr std::array<std::string_view, 6> kShapes{"faces", "part",   "material",
                                                  "label", "sphere", "box"};

Result<PointRequest> as_curve(std::vector<PointRequest> points, bool is_closed,
                              std::string parameter) {
  const std::size_t least = is_closed ? 3 : 2;
  if (points.size() < least) {
    return fail(
        ErrorCode::value_out_of_range,
        is_closed ? "a closed curve has three points at least" : "a curve has two points at least",
        std::move(parameter));
  }
  for (const PointRequest& point : points) {
    if (point.offset == 0) continue;
    return fail(ErrorCode::value_out_of_range, "a point of a curve has no offset",
                point.parameter + ".offset");
  }
  PointRequest request;
  request.where = std::make_shared<const CurveRequest>(CurveRequest{std::move(points), is_closed});
  request.parameter = std::move(parameter);
  return request;
}

Result<void> check_curve_points(std::size_t count, const std::string& parameter) {
  if (count <= kMaxCurvePoints) return {};
  return fail_limit(ErrorCode::too_large,
                    "too many points in one curve; leave some out where the curve is straight, or "
                    "write it as several curves",
                    kMaxCurvePoints, count, parameter);
}

Result<PointRequest> parse_curve(std::string_view text, std::string parameter) {
  constexpr std::string_view kClosed = "closed;";
  const bool is_closed = text.starts_with(kClosed);
  if (is_closed) text.remove_prefix(kClosed.size());
  const auto count = static_cast<std::size_t>(std::count(text.begin(), text.end(), ';')) + 1;
  if (auto few = check_curve_points(count, parameter); !few) return fail(few.error());
  std::vector<PointRequest> points;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t end = std::min(text.find(';'), text.size());
    auto point = parse_point(text.substr(0, end), parameter + ".points[" + std::to_string(i) + "]");
    if (!point) return point;
    points.push_back(std::move(*point));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return as_curve(std::move(points), is_closed, std::move(parameter));
}

Result<PointRequest> parse_json_curve(const json& curve, std::string parameter) {
  const std::string inner = parameter + ".curve";
  if (!curve.is_object()) return no_source("\"curve\" is not an object", inner);
  if (auto known = check_only_has(curve, {"points", "closed"}, "a curve", inner); !known) {
    return fail(known.error());
  }
  const auto list = curve.find("points");
  if (list == curve.end() || !list->is_array()) {
    return no_source("\"points\" is not a list of points", inner + ".points");
  }
  if (auto few = check_curve_points(list->size(), inner + ".points"); !few) {
    return fail(few.error());
  }
  bool is_closed = false;
  if (const auto closed = curve.find("closed"); closed != curve.end()) {
    if (!closed->is_boolean()) {
      return no_source("\"closed\" is neither true nor false", inner + ".closed");
    }
    is_closed = closed->get<bool>();
  }
  std::vector<PointRequest> points;
  for (const json& item : *list) {
    auto point = parse_json_point(item, inner + ".points[" + std::to_string(points.size()) + "]");
    if (!point) return point;
    points.push_back(std::move(*point));
  }
  return as_curve(std::move(points), is_closed, std::move(parameter));
}

PointRequest on_boundary(std::optional<std::uint64_t> loop, std::string parameter) {
  PointRequest request;
  request.where = BoundaryRequest{loop};
  request.parameter = std::move(parameter);
  return request;
}

PointRequest of_faces(const json& shape, std::string parameter) {
  PointRequest request;
  request.where = FacesRequest{shape.dump(-1, ' ', false, json::error_handler_t::replace)};
  request.parameter = std::move(parameter);
  return request;
}

}  // namespace

Result<PointRequest> parse_source(std::string_view text, std::string parameter) {
  if (text == "boundary") return on_boundary(std::nullopt, std::move(parameter));
  if (text.starts_with("boundary:")) {
    const auto loop = parse_whole(text.substr(text.find(':') + 1));
    if (!loop) {
      return no_source("a boundary is written boundary or boundary:NUMBER, such as boundary:0",
                       std::move(parameter));
    }
    return on_boundary(*loop, std::move(parameter));
  }
  if (text.starts_with("curve:")) {
    return parse_curve(text.substr(text.find(':') + 1), std::move(parameter));
  }
  for (const std::string_view shape : kShapes) {
    if (text.starts_with(shape) && text.substr(shape.size()).starts_with(":")) {
      return of_faces(json(std::string(text)), std::move(parameter));
    }
  }
  return parse_point(text, std::move(parameter));
}

Result<PointRequest> parse_json_source(const json& value, std::string parameter) {
  if (value.is_string()) return parse_source(value.get_ref<const std::string&>(), parameter);
  if (!value.is_object()) return parse_json_point(value, std::move(parameter));
  if (const auto it = value.find("boundary"); it != value.end()) {
    if (auto known = check_only_has(value, {"boundary"}, "a source", parameter); !known) {
      return fail(known.error());
    }
    if (it->is_string() && it->get_ref<const std::string&>() == "all") {
      return on_boundary(std::nullopt, std::move(parameter));
    }
    const auto loop = whole_number(*it);
    if (!loop) {
      return no_source("\"boundary\" is neither a whole number nor \"all\"",
                       parameter + ".boundary");
    }
    return on_boundary(*loop, std::move(parameter));
  }
  if (const auto it = value.find("curve"); it != value.end()) {
    if (auto known = check_only_has(value, {"curve"}, "a source", parameter); !known) {
      return fail(known.error());
    }
    return parse_json_curve(*it, std::move(parameter));
  }
  for (const std::string_view shape : kShapes) {
    if (value.contains(shape)) return of_faces(value, std::move(parameter));
  }
  return parse_json_point(value, std::move(parameter));
}

}  // namespace geodesic::proto
