#include "proto/region/read_regions.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "proto/region/shapes.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/point_request.h"
#include "proto/wire/query_limits.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

tl::unexpected<Error> no_shape(std::string detail, std::string parameter) {
  return fail(InputCode::bad_syntax, std::move(detail), std::move(parameter));
}

std::string of_member(std::string_view name, std::string_view what) {
  std::string sentence(1, '"');
  sentence.append(name).append("\" ").append(what);
  return sentence;
}

// Nothing is ignored: all members of an object have to be there, and no others.
Result<void> check_members(const json& object, std::initializer_list<std::string_view> names,
                           const std::string& parameter) {
  if (!object.is_object()) return no_shape("this is not an object", parameter);
  for (const std::string_view name : names) {
    if (!object.contains(name)) {
      return no_shape(of_member(name, "is missing"), parameter);
    }
  }
  for (const auto& member : object.items()) {
    if (std::find(names.begin(), names.end(), member.key()) == names.end()) {
      return fail(InputCode::unknown_parameter, "a region of this kind has no such member",
                  parameter + "." + member.key());
    }
  }
  return {};
}

std::optional<double> finite_member(const json& value) {
  if (!value.is_number() || !std::isfinite(value.get<double>())) return std::nullopt;
  return value.get<double>();
}

Result<Vec3> place_member(const json& object, const char* name, const std::string& parameter) {
  const json& value = object[name];
  std::vector<double> numbers;
  for (std::size_t i = 0; value.is_array() && value.size() == 3 && i < 3; ++i) {
    if (const auto number = finite_member(value[i])) numbers.push_back(*number);
  }
  if (numbers.size() != 3) {
    return no_shape(of_member(name, "is not three numbers"), parameter + "." + name);
  }
  return Vec3{numbers[0], numbers[1], numbers[2]};
}

// [7, [10, 99]]
Result<Shape> faces_of(const json& list, std::string parameter) {
  if (!list.is_array()) {
    return no_shape("\"faces\" is not a list of numbers and ranges", parameter + ".faces");
  }
  std::vector<FaceRange> ranges;
  ranges.reserve(list.size());
  for (const json& item : list) {
    const bool is_range = item.is_array() && item.size() == 2;
    const auto first = whole_number(is_range ? item[0] : item);
    const auto last = whole_number(is_range ? item[1] : item);
    if (!first || !last) {
      return no_shape("a face is a whole number, and a range two of them",
                      parameter + ".faces[" + std::to_string(ranges.size()) + "]");
    }
    const auto range = face_range(*first, *last, ranges.size(), parameter);
    if (!range) return fail(range.error());
    ranges.push_back(*range);
  }
  return shape_of_faces(std::move(ranges), std::move(parameter));
}

Result<Shape> sphere_of(const json& sphere, std::string parameter) {
  const std::string inner = parameter + ".sphere";
  if (auto ok = check_members(sphere, {"center", "radius"}, inner); !ok) return fail(ok.error());
  const auto center = place_member(sphere, "center", inner);
  if (!center) return fail(center.error());
  const auto radius = finite_member(sphere["radius"]);
  if (!radius) return no_shape("\"radius\" is not a number", inner + ".radius");
  return sphere_shape(*center, *radius, std::move(parameter));
}

Result<Shape> box_of(const json& box, std::string parameter) {
  const std::string inner = parameter + ".box";
  if (auto ok = check_members(box, {"min", "max"}, inner); !ok) return fail(ok.error());
  const auto min = place_member(box, "min", inner);
  if (!min) return fail(min.error());
  const auto max = place_member(box, "max", inner);
  if (!max) return fail(max.error());
  return box_shape(*min, *max, std::move(parameter));
}

Result<std::vector<Shape>> read_region(Parameters& parameters, std::string_view name,
                                       std::uint64_t& ranges) {
  const std::size_t count = parameters.count(name);
  if (count > kMaxRegionShapes) {
    return fail_limit(ErrorCode::too_large,
                      "too many shapes in one region; ranges of faces take one", kMaxRegionShapes,
                      count, std::string(name));
  }
  const json* values = parameters.values(name);
  std::vector<Shape> region;
  if (values == nullptr) return region;
  if (values->empty()) {
    return fail(ErrorCode::value_out_of_range, "there is no region in this list",
                std::string(name));
  }
  for (std::size_t i = 0; i < count; ++i) {
    auto shape = parse_json_shape(
        (*values)[i],
        count == 1 ? std::string(name) : std::string(name) + "[" + std::to_string(i) + "]");
    if (!shape) return fail(std::move(shape.error()));
    if (const auto* faces = std::get_if<std::vector<FaceRange>>(&shape->what)) {
      ranges += faces->size();
      if (ranges > kMaxFaceRanges) {
        return fail_limit(ErrorCode::too_large,
                          "too many faces and ranges of them in one request; write what lies side "
                          "by side as one range",
                          kMaxFaceRanges, ranges, std::string(name));
      }
    }
    region.push_back(std::move(*shape));
  }
  return region;
}

}  // namespace

Result<Shape> parse_json_shape(const json& value, std::string parameter) {
  if (value.is_string()) {
    return parse_shape(value.get_ref<const std::string&>(), std::move(parameter));
  }
  if (!value.is_object()) return no_shape("a region is an object or a text", std::move(parameter));
  for (const char* name : {"faces", "part", "sphere", "box"}) {
    if (!value.contains(name)) continue;
    if (auto ok = check_members(value, {name}, parameter); !ok) return fail(ok.error());
    const json& inner = value[name];
    switch (*name) {
      case 'f':
        return faces_of(inner, std::move(parameter));
      case 's':
        return sphere_of(inner, std::move(parameter));
      case 'b':
        return box_of(inner, std::move(parameter));
      default:
        break;
    }
    const auto part = whole_number(inner);
    if (!part) return no_shape("\"part\" is not a whole number", parameter + ".part");
    return Shape{PartShape{*part}, std::move(parameter)};
  }
  return no_shape(R"(a region has "faces", "part", "sphere" or "box")", std::move(parameter));
}

Result<Regions> read_regions(Parameters& parameters) {
  std::uint64_t ranges = 0;
  auto within = read_region(parameters, "within", ranges);
  if (!within) return fail(std::move(within.error()));
  auto forbid = read_region(parameters, "forbid", ranges);
  if (!forbid) return fail(std::move(forbid.error()));
  return Regions{std::move(*within), std::move(*forbid)};
}

}  // namespace geodesic::proto
