#include "proto/region/read_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
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

// All of these members have to be there, and no others.
Result<void> check_members(const json& object, std::initializer_list<std::string_view> names,
                           const std::string& parameter) {
  if (!object.is_object()) return no_shape("this is not an object", parameter);
  for (const std::string_view name : names) {
    if (!object.contains(name)) {
      return no_shape(of_member(name, "is missing"), parameter);
    }
  }
  return check_only_has(object, names, "a region", parameter);
}

Result<Vec3> place_member(const json& object, const char* name, const std::string& parameter) {
  const auto numbers = finite_numbers(object[name], 3);
  if (!numbers) return no_shape(of_member(name, "is not three numbers"), parameter + "." + name);
  return Vec3{(*numbers)[0], (*numbers)[1], (*numbers)[2]};
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

Result<Shape> part_of(const json& value, std::string parameter) {
  if (value.is_string()) return Shape{PartShape{value.get<std::string>()}, std::move(parameter)};
  const auto part = whole_number(value);
  if (!part) {
    return no_shape("\"part\" is neither a whole number nor a name", parameter + ".part");
  }
  return Shape{PartShape{*part}, std::move(parameter)};
}

Result<Shape> material_of(const json& value, std::string parameter) {
  if (value.is_null()) return Shape{MaterialShape{NoMaterial{}}, std::move(parameter)};
  if (value.is_string()) {
    return Shape{MaterialShape{value.get<std::string>()}, std::move(parameter)};
  }
  const auto material = whole_number(value);
  if (!material) {
    return no_shape("\"material\" is neither a whole number, nor a name, nor null",
                    parameter + ".material");
  }
  return Shape{MaterialShape{*material}, std::move(parameter)};
}

Result<Shape> label_of(const json& label, std::string parameter) {
  const std::string inner = parameter + ".label";
  if (auto ok = check_members(label, {"attribute", "value"}, inner); !ok) return fail(ok.error());
  const json& attribute = label["attribute"];
  const json& value = label["value"];
  if (!attribute.is_string()) return no_shape("\"attribute\" is not a text", inner + ".attribute");
  if (!value.is_number() || !std::isfinite(value.get<double>())) {
    return no_shape("\"value\" is not a number", inner + ".value");
  }
  return label_shape(attribute.get<std::string>(), value.get<double>(), std::move(parameter));
}

Result<Shape> sphere_of(const json& sphere, std::string parameter) {
  const std::string inner = parameter + ".sphere";
  if (auto ok = check_members(sphere, {"center", "radius"}, inner); !ok) return fail(ok.error());
  const auto center = place_member(sphere, "center", inner);
  if (!center) return fail(center.error());
  const json& radius = sphere["radius"];
  if (!radius.is_number() || !std::isfinite(radius.get<double>())) {
    return no_shape("\"radius\" is not a number", inner + ".radius");
  }
  return sphere_shape(*center, radius.get<double>(), std::move(parameter));
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

Result<void> check_line_points(std::uint64_t points, std::string parameter) {
  if (points <= kMaxLinePoints) return {};
  return fail_limit(ErrorCode::too_large,
                    "too many points of walls and insides in one request; ask with fewer",
                    kMaxLinePoints, points, std::move(parameter));
}

Result<std::vector<PointRequest>> points_of(const json& list, const std::string& parameter) {
  if (!list.is_array()) return no_shape("a line is a list of points", parameter);
  if (auto few = check_line_points(list.size(), parameter); !few) {
    return fail(std::move(few.error()));
  }
  std::vector<PointRequest> points;
  points.reserve(list.size());
  for (const json& item : list) {
    auto point = parse_json_point(item, parameter + "[" + std::to_string(points.size()) + "]");
    if (!point) return fail(std::move(point.error()));
    points.push_back(std::move(*point));
  }
  return points;
}

Result<Shape> inside_of(const json& list, std::string parameter) {
  auto points = points_of(list, parameter + ".inside");
  if (!points) return fail(std::move(points.error()));
  return inside_shape(std::move(*points), std::move(parameter));
}

// How much of what a query may have of them there has been.
struct Counted {
  std::uint64_t ranges = 0;
  std::uint64_t line_points = 0;
};

// How many points a line has as the client wrote it: all of a text that begins so, or what an
// object has in that member. 0 where there is none.
std::uint64_t line_points_in(const json& value, std::string_view beginning, const char* member) {
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    if (!text.starts_with(beginning)) return 0;
    return static_cast<std::uint64_t>(std::count(text.begin(), text.end(), ';')) + 1;
  }
  const auto list = value.find(member);
  return list != value.end() && list->is_array() ? list->size() : 0;
}

// Counts the points of a line before they are made: each takes many times its text.
Result<void> count_line(std::uint64_t points, Counted& counted, std::string_view name) {
  counted.line_points += points;
  return check_line_points(counted.line_points, std::string(name));
}

// Of several values under a name, which one.
std::string parameter_at(std::string_view name, std::size_t i, std::size_t count) {
  return count == 1 ? std::string(name) : std::string(name) + "[" + std::to_string(i) + "]";
}

Result<std::vector<Wall>> read_walls(Parameters& parameters, Counted& counted) {
  constexpr std::string_view kName = "walls";
  const std::size_t count = parameters.count(kName);
  if (count > kMaxWalls) {
    return fail_limit(ErrorCode::too_large,
                      "too many walls in one request; one may go through many points", kMaxWalls,
                      count, std::string(kName));
  }
  const json* values = parameters.values(kName);
  std::vector<Wall> walls;
  if (values == nullptr) return walls;
  if (values->empty()) {
    return fail(ErrorCode::value_out_of_range, "there is no wall in this list", std::string(kName));
  }
  for (std::size_t i = 0; i < count; ++i) {
    const json& value = (*values)[i];
    if (auto few = count_line(line_points_in(value, "", "points"), counted, kName); !few) {
      return fail(std::move(few.error()));
    }
    auto wall = parse_json_wall(value, parameter_at(kName, i, count));
    if (!wall) return fail(std::move(wall.error()));
    walls.push_back(std::move(*wall));
  }
  return walls;
}

Result<std::vector<Shape>> read_region(Parameters& parameters, std::string_view name,
                                       Counted& counted) {
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
    const json& value = (*values)[i];
    if (auto few = count_line(line_points_in(value, "inside:", "inside"), counted, name); !few) {
      return fail(std::move(few.error()));
    }
    auto shape = parse_json_shape(value, parameter_at(name, i, count));
    if (!shape) return fail(std::move(shape.error()));
    if (const auto* faces = std::get_if<std::vector<FaceRange>>(&shape->what)) {
      counted.ranges += faces->size();
      if (counted.ranges > kMaxFaceRanges) {
        return fail_limit(ErrorCode::too_large,
                          "too many faces and ranges of them in one request; write what lies side "
                          "by side as one range",
                          kMaxFaceRanges, counted.ranges, std::string(name));
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
  constexpr std::array<std::pair<const char*, Result<Shape> (*)(const json&, std::string)>, 7>
      kKinds{{{"faces", faces_of},
              {"part", part_of},
              {"material", material_of},
              {"label", label_of},
              {"sphere", sphere_of},
              {"box", box_of},
              {"inside", inside_of}}};
  for (const auto& [name, shape_of] : kKinds) {
    if (!value.contains(name)) continue;
    if (auto ok = check_members(value, {name}, parameter); !ok) return fail(ok.error());
    return shape_of(value[name], std::move(parameter));
  }
  return no_shape(
      R"(a region has "faces", "part", "material", "label", "sphere", "box" or "inside")",
      std::move(parameter));
}

Result<Wall> parse_json_wall(const json& value, std::string parameter) {
  if (value.is_string()) {
    return parse_wall(value.get_ref<const std::string&>(), std::move(parameter));
  }
  if (!value.is_object() || !value.contains("points")) {
    return no_shape(R"(a wall is a text or an object with "points")", std::move(parameter));
  }
  if (auto known = check_only_has(value, {"points"}, "a wall", parameter); !known) {
    return fail(std::move(known.error()));
  }
  auto points = points_of(value["points"], parameter + ".points");
  if (!points) return fail(std::move(points.error()));
  return wall_through(std::move(*points), std::move(parameter));
}

Result<Regions> read_regions(Parameters& parameters) {
  Counted counted;
  auto within = read_region(parameters, "within", counted);
  if (!within) return fail(std::move(within.error()));
  auto forbid = read_region(parameters, "forbid", counted);
  if (!forbid) return fail(std::move(forbid.error()));
  auto walls = read_walls(parameters, counted);
  if (!walls) return fail(std::move(walls.error()));
  return Regions{std::move(*within), std::move(*forbid), std::move(*walls)};
}

}  // namespace geodesic::proto
