// A point as a client names it, before it is found on a mesh. One grammar
// everywhere (docs: "Points" in openapi.yaml):
//   in a URL              in JSON                                 is
//   v:12                  {"vertex":12}                           a source vertex
//   f:40,0.2,0.3          {"face":40,"bary":[0.2,0.3,0.5]}        a point on a source face
//   p:1,2,3               {"xyz":[1,2,3],"max_snap":0.1}          the closest point of the surface
//   ray:0,0,9,0,0,-1      {"ray":{"origin":[0,0,9],               the first hit of a ray: its
//   origin
//                                 "direction":[0,0,-1]}}          and its direction, of any length
// JSON accepts the URL's text as well.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/error.h"
#include "core/base/vec3.h"

namespace geodesic::proto {

struct VertexRequest {
  std::uint64_t vertex;
};

struct FaceRequest {
  std::uint64_t face;
  std::array<double, 3> bary;  // not negative, sum 1 up to rounding
};

struct SpaceRequest {
  Vec3 xyz;
  std::optional<double> max_snap;  // mesh units; farther from the surface is an error
};

struct RayRequest {
  Vec3 origin;
  Vec3 direction;  // not zero
};

struct PointRequest {
  std::variant<VertexRequest, FaceRequest, SpaceRequest, RayRequest> where;
  double offset = 0;      // mesh units, not negative
  std::string parameter;  // where the client wrote it, such as "from[2]", for errors
};

// What JSON Schema calls an integer, 1.0 and 1e0 too, of 0 to 2^64 - 1.
[[nodiscard]] std::optional<std::uint64_t> whole_number(const nlohmann::json& value);

// An array of so many finite numbers.
[[nodiscard]] std::optional<std::vector<double>> finite_numbers(const nlohmann::json& value,
                                                                std::size_t count);

// Nothing is ignored: an object has no other members than these. `what` it is, for the error, such
// as "a point". Errors: unknown_parameter.
[[nodiscard]] Result<void> check_only_has(const nlohmann::json& object,
                                          std::initializer_list<std::string_view> names,
                                          std::string_view what, const std::string& parameter);

// `parameter` is what errors name. Errors: bad_syntax, value_out_of_range.
[[nodiscard]] Result<PointRequest> parse_point(std::string_view text, std::string parameter);
[[nodiscard]] Result<PointRequest> parse_json_point(const nlohmann::json& value,
                                                    std::string parameter);

}  // namespace geodesic::proto
