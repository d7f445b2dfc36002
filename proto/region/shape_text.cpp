// Shapes as a URL has them.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "proto/region/read_regions.h"
#include "proto/region/shapes.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/number.h"
#include "proto/wire/query_limits.h"

namespace geodesic::proto {
namespace {

// 2, roof or "2" with its quotes (region.h); nothing if it is neither.
std::optional<std::variant<std::uint64_t, std::string>> place_or_name(std::string_view text) {
  if (text.empty()) return std::nullopt;
  if (text.find_first_not_of("0123456789") == text.npos) {
    const auto place = parse_whole(text);
    if (!place) return std::nullopt;
    return *place;
  }
  const bool is_quoted = text.size() > 1 && text.front() == '"' && text.back() == '"';
  return std::string(is_quoted ? text.substr(1, text.size() - 2) : text);
}

tl::unexpected<Error> badly_written(const char* how, std::string parameter) {
  return fail(InputCode::bad_syntax, how, std::move(parameter));
}

// "7,10-99"
Result<Shape> parse_faces(std::string_view text, std::string parameter) {
  std::vector<FaceRange> ranges;
  for (;;) {
    const std::size_t comma = text.find(',');
    const std::string_view item = text.substr(0, comma);
    const std::size_t dash = item.find('-');
    const auto first = parse_whole(item.substr(0, dash));
    const auto last = dash == item.npos ? first : parse_whole(item.substr(dash + 1));
    if (!first || !last) {
      return badly_written("faces are written faces:NUMBER,FIRST-LAST, such as faces:7,10-99",
                           std::move(parameter));
    }
    const auto range = face_range(*first, *last, ranges.size(), parameter);
    if (!range) return fail(range.error());
    ranges.push_back(*range);
    if (comma == text.npos) return shape_of_faces(std::move(ranges), std::move(parameter));
    text.remove_prefix(comma + 1);
  }
}

}  // namespace

Result<std::vector<PointRequest>> parse_line(std::string_view text, const std::string& parameter) {
  // Before they are made: a point takes many times its text.
  const auto count = static_cast<std::uint64_t>(std::count(text.begin(), text.end(), ';')) + 1;
  if (count > kMaxLinePoints) {
    return fail_limit(ErrorCode::too_large,
                      "too many points of walls and insides in one request; ask with fewer",
                      kMaxLinePoints, count, parameter);
  }
  std::vector<PointRequest> points;
  for (;;) {
    const std::size_t end = text.find(';');
    auto point =
        parse_point(text.substr(0, end), parameter + "[" + std::to_string(points.size()) + "]");
    if (!point) return fail(std::move(point.error()));
    points.push_back(std::move(*point));
    if (end == text.npos) return points;
    text.remove_prefix(end + 1);
  }
}

Result<Wall> parse_wall(std::string_view text, std::string parameter) {
  auto points = parse_line(text, parameter + ".points");
  if (!points) return fail(std::move(points.error()));
  return wall_through(std::move(*points), std::move(parameter));
}

Result<Shape> parse_shape(std::string_view text, std::string parameter) {
  if (text.starts_with("faces:")) return parse_faces(text.substr(6), std::move(parameter));
  if (text.starts_with("part:")) {
    if (auto part = place_or_name(text.substr(5))) {
      return Shape{PartShape{std::move(*part)}, std::move(parameter)};
    }
    return badly_written(
        "a part is written part:NUMBER or part:NAME, such as part:2, part:roof or part:\"2\"",
        std::move(parameter));
  }
  if (text.starts_with("material:")) {
    const std::string_view said = text.substr(9);
    if (said == "none") return Shape{MaterialShape{NoMaterial{}}, std::move(parameter)};
    if (auto material = place_or_name(said)) {
      return Shape{
          std::visit([](auto& value) { return MaterialShape{std::move(value)}; }, *material),
          std::move(parameter)};
    }
    return badly_written(
        "a material is written material:NUMBER, material:NAME or material:none, such as "
        "material:3, "
        "material:glass or material:\"3\"",
        std::move(parameter));
  }
  if (text.starts_with("label:")) {
    const std::string_view said = text.substr(6);
    const std::size_t equals = said.rfind('=');
    const auto value = equals == said.npos ? std::nullopt : parse_finite(said.substr(equals + 1));
    if (value)
      return label_shape(std::string(said.substr(0, equals)), *value, std::move(parameter));
    return badly_written("a label is written label:ATTRIBUTE=NUMBER, such as label:_SEG=3",
                         std::move(parameter));
  }
  if (text.starts_with("sphere:")) {
    const auto n = numbers_between_commas(text.substr(7));
    if (n && n->size() == 4) {
      return sphere_shape({(*n)[0], (*n)[1], (*n)[2]}, (*n)[3], std::move(parameter));
    }
    return badly_written("a sphere is written sphere:X,Y,Z,RADIUS, such as sphere:1,2,3,0.5",
                         std::move(parameter));
  }
  if (text.starts_with("box:")) {
    const auto n = numbers_between_commas(text.substr(4));
    if (n && n->size() == 6) {
      return box_shape({(*n)[0], (*n)[1], (*n)[2]}, {(*n)[3], (*n)[4], (*n)[5]},
                       std::move(parameter));
    }
    return badly_written(
        "a box is written box:MINX,MINY,MINZ,MAXX,MAXY,MAXZ, such as box:0,0,0,1,2,3",
        std::move(parameter));
  }
  if (text.starts_with("inside:")) {
    auto points = parse_line(text.substr(7), parameter + ".inside");
    if (!points) return fail(std::move(points.error()));
    return inside_shape(std::move(*points), std::move(parameter));
  }
  return badly_written(
      "a region is written faces:FIRST-LAST, part:NUMBER, part:NAME, material:NUMBER, "
      "material:NAME, material:none, label:ATTRIBUTE=NUMBER, sphere:X,Y,Z,RADIUS, "
      "box:MINX,MINY,MINZ,MAXX,MAXY,MAXZ or inside:POINT;POINT;POINT",
      std::move(parameter));
}

}  // namespace geodesic::proto
