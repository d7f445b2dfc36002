#include "proto/wire/point_request.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/wire/input_codes.h"
#include "proto/wire/number.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

// Weights may miss their sum by this much, as decimal fractions do.
constexpr double kWeightSlack = 1e-6;

// What only a field can start from, by the word that it begins with or the member that it has.
constexpr std::array<std::string_view, 7> kNoPoints{"boundary", "curve",  "faces", "part",
                                                    "material", "sphere", "box"};
// What not even a field can start from.
constexpr std::string_view kInside = "inside";

bool is_no_point(std::string_view word) {
  return word == kInside || std::find(kNoPoints.begin(), kNoPoints.end(), word) != kNoPoints.end();
}

tl::unexpected<Error> no_point(std::string_view word, std::string parameter) {
  if (word == kInside) {
    return fail(ErrorCode::value_out_of_range,
                "the inside of a line is for within and forbid alone: it is neither a point nor a "
                "set of whole faces",
                std::move(parameter));
  }
  return fail(ErrorCode::value_out_of_range,
              "this is to be a point; curves, boundaries and faces are what distance, path, table, "
              "isolines, measure, samples and voronoi take as from, a curve as curve:POINT;POINT",
              std::move(parameter));
}

tl::unexpected<Error> bad(std::string detail, std::string parameter) {
  return fail(InputCode::bad_syntax, std::move(detail), std::move(parameter));
}

Result<PointRequest> on_face(std::uint64_t face, std::array<double, 3> bary, double offset,
                             std::string parameter) {
  for (double& weight : bary) {
    if (weight < -kWeightSlack) {
      return fail(ErrorCode::value_out_of_range, "a barycentric weight is negative",
                  std::move(parameter));
    }
    weight = std::max(weight, 0.0);
  }
  if (std::abs(bary[0] + bary[1] + bary[2] - 1) > 3 * kWeightSlack) {
    return fail(ErrorCode::value_out_of_range, "barycentric weights do not add up to 1",
                std::move(parameter));
  }
  return PointRequest{FaceRequest{face, bary}, offset, std::move(parameter)};
}

Result<PointRequest> on_ray(const std::vector<double>& origin, const std::vector<double>& direction,
                            double offset, std::string parameter) {
  if (direction[0] == 0 && direction[1] == 0 && direction[2] == 0) {
    return fail(ErrorCode::value_out_of_range, "a ray's direction is not zero",
                std::move(parameter));
  }
  return PointRequest{
      RayRequest{{origin[0], origin[1], origin[2]}, {direction[0], direction[1], direction[2]}},
      offset, std::move(parameter)};
}

// The six numbers of ray:OX,OY,OZ,DX,DY,DZ.
Result<PointRequest> parse_ray(std::string_view text, std::string parameter) {
  std::vector<double> numbers;
  for (const char* at = text.data();;) {
    const char* end = text.data() + text.size();
    double value = 0;
    const auto [stop, error] = std::from_chars(at, end, value);
    if (error == std::errc::result_out_of_range ||
        (error == std::errc() && !std::isfinite(value))) {
      return fail(ErrorCode::value_out_of_range, "a ray's numbers are finite",
                  std::move(parameter));
    }
    if (error != std::errc() || (stop != end && *stop != ',')) break;
    numbers.push_back(value);
    if (stop == end && numbers.size() == 6) {
      return on_ray({numbers.begin(), numbers.begin() + 3}, {numbers.begin() + 3, numbers.end()}, 0,
                    std::move(parameter));
    }
    if (stop == end || numbers.size() == 6) break;
    at = stop + 1;
  }
  return bad("a ray is written ray:OX,OY,OZ,DX,DY,DZ, such as ray:0,0,9,0,0,-1",
             std::move(parameter));
}

// A member that must be a finite number, not negative, if it is there.
Result<std::optional<double>> length_member(const json& point, const char* name,
                                            const std::string& parameter) {
  const auto it = point.find(name);
  if (it == point.end()) return std::optional<double>();
  if (!it->is_number()) {
    return bad(std::string("\"") + name + "\" is not a number", parameter + "." + name);
  }
  const auto value = it->get<double>();
  if (!(value >= 0) || !std::isfinite(value)) {
    return fail(ErrorCode::value_out_of_range, std::string("\"") + name + "\" is negative",
                parameter + "." + name);
  }
  return std::optional(value);
}

Result<PointRequest> parse_json_ray(const json& ray, double offset, std::string parameter) {
  const std::string inner = parameter + ".ray";
  if (!ray.is_object()) return bad("\"ray\" is not an object", inner);
  if (auto known = check_only_has(ray, {"origin", "direction"}, "a point", inner); !known) {
    return fail(known.error());
  }
  const auto origin = finite_numbers(ray.value("origin", json()), 3);
  if (!origin) return bad("\"origin\" is not three numbers", inner + ".origin");
  const auto direction = finite_numbers(ray.value("direction", json()), 3);
  if (!direction) return bad("\"direction\" is not three numbers", inner + ".direction");
  return on_ray(*origin, *direction, offset, std::move(parameter));
}

}  // namespace

std::optional<std::uint64_t> whole_number(const json& value) {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  if (!value.is_number()) return std::nullopt;
  const auto number = value.get<double>();  // -0 or less, or written as a fraction
  constexpr double kTooMuch = 0x1p64;
  if (!(number >= 0 && number < kTooMuch) || std::floor(number) != number) return std::nullopt;
  return static_cast<std::uint64_t>(number);
}

std::optional<std::vector<double>> finite_numbers(const json& value, std::size_t count) {
  if (!value.is_array() || value.size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const json& item : value) {
    if (!item.is_number() || !std::isfinite(item.get<double>())) return std::nullopt;
    numbers.push_back(item.get<double>());
  }
  return numbers;
}

Result<void> check_only_has(const json& object, std::initializer_list<std::string_view> names,
                            std::string_view what, const std::string& parameter) {
  for (const auto& member : object.items()) {
    if (std::find(names.begin(), names.end(), member.key()) == names.end()) {
      return fail(InputCode::unknown_parameter,
                  std::string(what).append(" of this kind has no such member"),
                  parameter + "." + member.key());
    }
  }
  return {};
}

Result<PointRequest> parse_point(std::string_view text, std::string parameter) {
  if (text.starts_with("v:")) {
    if (const auto vertex = parse_whole(text.substr(2))) {
      return PointRequest{VertexRequest{*vertex}, 0, std::move(parameter)};
    }
    return bad("a vertex is written v:NUMBER, such as v:12", std::move(parameter));
  }
  if (text.starts_with("f:")) {
    const std::size_t comma = text.find(',');
    const auto face = parse_whole(text.substr(2, comma == text.npos ? comma : comma - 2));
    const auto weights =
        comma == text.npos ? std::nullopt : numbers_between_commas(text.substr(comma + 1));
    if (!face || !weights || weights->size() != 2) {
      return bad("a point on a face is written f:FACE,W0,W1, such as f:40,0.2,0.3",
                 std::move(parameter));
    }
    const double a = (*weights)[0];
    const double b = (*weights)[1];
    return on_face(*face, {a, b, 1 - a - b}, 0, std::move(parameter));
  }
  if (text.starts_with("p:")) {
    const auto xyz = numbers_between_commas(text.substr(2));
    if (!xyz || xyz->size() != 3) {
      return bad("a point in space is written p:X,Y,Z, such as p:1,2,3", std::move(parameter));
    }
    return PointRequest{SpaceRequest{{(*xyz)[0], (*xyz)[1], (*xyz)[2]}, std::nullopt}, 0,
                        std::move(parameter)};
  }
  if (text.starts_with("ray:")) return parse_ray(text.substr(4), std::move(parameter));
  const std::string_view word = text.substr(0, text.find(':'));
  if (is_no_point(word)) return no_point(word, std::move(parameter));
  return bad(
      "a point is written v:VERTEX, f:FACE,W0,W1, p:X,Y,Z or ray:OX,OY,OZ,DX,DY,DZ; where lines "
      "and "
      "faces may stand, curve:POINT;POINT, boundary, faces:0-9, part:, material: or label: too",
      std::move(parameter));
}

Result<PointRequest> parse_json_point(const json& value, std::string parameter) {
  if (value.is_string()) return parse_point(value.get_ref<const std::string&>(), parameter);
  if (!value.is_object()) {
    return bad(R"(a point is an object or a text, such as {"vertex":1} or "v:1")",
               std::move(parameter));
  }
  const auto offset = length_member(value, "offset", parameter);
  if (!offset) return fail(offset.error());
  const auto max_snap = length_member(value, "max_snap", parameter);
  if (!max_snap) return fail(max_snap.error());

  if (const auto it = value.find("vertex"); it != value.end()) {
    if (auto known = check_only_has(value, {"vertex", "offset"}, "a point", parameter); !known)
      return fail(known.error());
    const auto vertex = whole_number(*it);
    if (!vertex) {
      return bad("\"vertex\" is not a whole number", parameter + ".vertex");
    }
    return PointRequest{VertexRequest{*vertex}, offset->value_or(0), std::move(parameter)};
  }
  if (const auto it = value.find("face"); it != value.end()) {
    if (auto known = check_only_has(value, {"face", "bary", "offset"}, "a point", parameter);
        !known)
      return fail(known.error());
    const auto face = whole_number(*it);
    if (!face) {
      return bad("\"face\" is not a whole number", parameter + ".face");
    }
    const auto bary = finite_numbers(value.value("bary", json()), 3);
    if (!bary) return bad("\"bary\" is not three numbers", parameter + ".bary");
    return on_face(*face, {(*bary)[0], (*bary)[1], (*bary)[2]}, offset->value_or(0),
                   std::move(parameter));
  }
  if (const auto it = value.find("xyz"); it != value.end()) {
    if (auto known = check_only_has(value, {"xyz", "max_snap", "offset"}, "a point", parameter);
        !known)
      return fail(known.error());
    const auto xyz = finite_numbers(*it, 3);
    if (!xyz) return bad("\"xyz\" is not three numbers", parameter + ".xyz");
    return PointRequest{SpaceRequest{{(*xyz)[0], (*xyz)[1], (*xyz)[2]}, *max_snap},
                        offset->value_or(0), std::move(parameter)};
  }
  if (const auto it = value.find("ray"); it != value.end()) {
    if (auto known = check_only_has(value, {"ray", "offset"}, "a point", parameter); !known) {
      return fail(known.error());
    }
    return parse_json_ray(*it, offset->value_or(0), std::move(parameter));
  }
  for (const auto& member : value.items()) {
    if (is_no_point(member.key())) return no_point(member.key(), std::move(parameter));
  }
  return bad("a point has \"vertex\", \"face\", \"xyz\" or \"ray\"", std::move(parameter));
}

}  // namespace geodesic::proto
