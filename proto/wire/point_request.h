// A point as a client names it, before it is found on a mesh. One grammar
// everywhere (docs: "Points" in openapi.yaml):
//   in a URL              in JSON                                 is
//   v:12                  {"vertex":12}                           a source vertex
//   f:40,0.2,0.3          {"face":40,"bary":[0.2,0.3,0.5]}        a point on a source face
//   p:1,2,3               {"xyz":[1,2,3],"max_snap":0.1}          the closest point of the surface
//   ray:0,0,9,0,0,-1      {"ray":{"origin":[0,0,9],               the first hit of a ray; its
//                                 "direction":[0,0,-1]}}          direction is of any length
// JSON accepts the URL's text as well.
//
// What a field starts from may be more than points (docs: "Sources" in openapi.yaml):
//   boundary              {"boundary":"all"}              all edges that have one face
//   boundary:0            {"boundary":0}                  a loop of them, 0 the longest
//   curve:v:1;p:1,2,3     {"curve":{"points":["v:1",…]}}  the shortest way, point to point
//   curve:closed;v:1;v:7  {"curve":{…,"closed":true}}     and back to the first
//   faces:7,10-99         {"faces":[7,[10,99]]}           whole faces, and other shapes of regions
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
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

struct BoundaryRequest {
  std::optional<std::uint64_t> loop;  // none: all of them
};

struct CurveRequest;

// The faces of a region's shape, which is read where regions are (proto/region).
struct FacesRequest {
  std::string shape;  // JSON
};

struct PointRequest {
  std::variant<VertexRequest, FaceRequest, SpaceRequest, RayRequest, BoundaryRequest,
               std::shared_ptr<const CurveRequest>, FacesRequest>
      where;
  double offset = 0;      // mesh units, not negative
  std::string parameter;  // where the client wrote it, such as "from[2]", for errors

  // False for what only a field can start from.
  [[nodiscard]] bool is_point() const { return where.index() < 4; }
};

struct CurveRequest {
  std::vector<PointRequest> points;  // two or more; three or more where it is closed
  bool is_closed = false;
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
// The same, or what else a field may start from. Errors besides: too_large (points of a curve).
[[nodiscard]] Result<PointRequest> parse_source(std::string_view text, std::string parameter);
[[nodiscard]] Result<PointRequest> parse_json_source(const nlohmann::json& value,
                                                     std::string parameter);

}  // namespace geodesic::proto
