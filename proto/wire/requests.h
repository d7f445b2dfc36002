// What each query asks, as values: parsed and within its domain, but not yet
// held against a mesh.
//
// `parse_request` reads a query's own parameters. It leaves `format` and
// `precision` to parse_format, and what nobody knows to
// Parameters::check_all_known. Its errors: bad_syntax, value_out_of_range,
// method_unknown, too_large (over one of query_limits.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/error.h"
#include "core/base/vec3.h"
#include "proto/wire/methods.h"
#include "proto/wire/parameters.h"
#include "proto/wire/point_request.h"
#include "proto/wire/reply_format.h"

namespace geodesic::proto {

struct DistanceRequest {
  std::vector<PointRequest> from;
  std::vector<PointRequest> at;  // empty: all source vertices
  MethodChoice method;
  std::optional<double> max;  // mesh units
  bool labels = false;        // say which source each distance is from
  bool is_signed = false;     // below 0 inside the closed curve that is the only source
};

enum class Refine : std::uint8_t { none, shortest };

struct PathRequest {
  PointRequest from;
  std::vector<PointRequest> via;  // in this order
  PointRequest to;
  MethodChoice method;
  Refine refine = Refine::shortest;
};

struct TableRequest {
  std::vector<PointRequest> from;  // a row each, of those that are asked for
  std::vector<PointRequest> to;    // a column each; empty: `from` again
  MethodChoice method;
  std::optional<double> max;
  bool stream = false;          // rows are sent as they are done
  bool sparse = false;          // only what is reached
  std::uint64_t landmarks = 0;  // columns with whole fields, by which others are estimated; 0: none
  std::uint64_t first_row = 0;  // which one of the whole table `from` begins with
  std::uint64_t all_rows = 0;   // how many that has
};

struct IsolinesRequest {
  struct Step {
    double size;  // mesh units, above 0: a line at each multiple of it
  };
  struct Count {
    std::uint64_t levels;  // evenly between 0 and the greatest distance
  };
  std::vector<PointRequest> from;
  std::variant<std::vector<double>, Step, Count> levels;
  MethodChoice method;
  std::optional<double> max;
};

struct SamplesRequest {
  std::uint64_t count = 0;
  std::vector<PointRequest> from;  // covered already
  MethodChoice method;
};

struct MeasureRequest {
  std::vector<PointRequest> from;
  std::vector<double> radii;  // mesh units; ascending, each once
  MethodChoice method;
  std::optional<double> max;  // no radius is greater
};

struct ExtentRequest {
  enum class Of : std::uint8_t { diameter, center, median, mean, means };
  Of of = Of::diameter;
  std::uint64_t fields = 100;  // that may be computed
  MethodChoice method;
};

struct VoronoiRequest {
  enum class Part : std::uint8_t { cells, bisectors, delaunay };
  std::vector<PointRequest> from;  // the sites
  std::uint64_t relax = 0;         // rounds
  std::optional<Part> part;        // that a GLB is to show; none: cells
  MethodChoice method;
};

struct TraceRequest {
  PointRequest from;
  std::variant<Vec3, double> ahead;  // a vector in space, or an angle in radians
  double length = 0;                 // mesh units, not negative
};

struct LoopRequest {
  enum class Start : std::uint8_t {
    through,  // the points, by shortest paths, which the loop keeps
    around,   // the same to begin with
    plane,    // the section through a point, or what it becomes
  };
  Start start = Start::plane;
  std::vector<PointRequest> points;  // of a plane one, else 2 or more
  Vec3 normal;                       // where it starts from a plane
  // The convex hull of the section: by the plane, or by that through the three points it is around.
  bool hull = false;
  MethodChoice method;  // unless is_of_plane()

  // Whether it is made of a plane's section, not of paths.
  [[nodiscard]] bool is_of_plane() const { return start == Start::plane || hull; }
};

struct LogmapRequest {
  PointRequest from;
  double angle = 0;              // of the direction that becomes the x axis, radians
  std::optional<double> radius;  // mesh units, above 0
  bool transport = false;        // the direction of the x axis is carried along each path
  MethodChoice method;
};

struct NearestRequest {
  std::vector<PointRequest> points;
};

// As clients write it.
[[nodiscard]] std::string_view name_of(ExtentRequest::Of of);
[[nodiscard]] std::string_view name_of(LoopRequest::Start start);

[[nodiscard]] Result<void> parse_request(Parameters& parameters, DistanceRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, PathRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, TableRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, IsolinesRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, SamplesRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, MeasureRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, ExtentRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, VoronoiRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, TraceRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, LoopRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, LogmapRequest& request);
[[nodiscard]] Result<void> parse_request(Parameters& parameters, NearestRequest& request);

// The formats that a query can be answered in.
[[nodiscard]] inline std::span<const Format> formats_of(const DistanceRequest& request) {
  if (request.labels && (request.is_signed || !request.at.empty())) return kLabelsAtPoints;
  if (request.is_signed) return request.at.empty() ? kSignedFormats : kSignedAtPoints;
  if (request.labels) return kLabelFormats;
  if (!request.at.empty()) return kArrayFormats;
  return kFieldFormats;
}
[[nodiscard]] inline std::span<const Format> formats_of(const PathRequest&) { return kPathFormats; }
[[nodiscard]] inline std::span<const Format> formats_of(const TableRequest& request) {
  if (request.stream) return request.sparse ? kLinesOnly : kRowFormats;
  return request.sparse ? std::span<const Format>(kSparseFormats) : kArrayFormats;
}
[[nodiscard]] inline std::span<const Format> formats_of(const IsolinesRequest&) {
  return kJsonOrLines;
}
[[nodiscard]] inline std::span<const Format> formats_of(const SamplesRequest&) { return kJsonOnly; }
[[nodiscard]] inline std::span<const Format> formats_of(const MeasureRequest&) {
  return kJsonOrSurface;
}
[[nodiscard]] inline std::span<const Format> formats_of(const ExtentRequest& request) {
  if (request.of == ExtentRequest::Of::means) return kFieldFormats;
  return kJsonOnly;
}
[[nodiscard]] inline std::span<const Format> formats_of(const VoronoiRequest& request) {
  if (request.part) return kSurfaceOnly;
  return kJsonOrPictures;
}
[[nodiscard]] inline std::span<const Format> formats_of(const TraceRequest&) {
  return kPathFormats;
}
[[nodiscard]] inline std::span<const Format> formats_of(const LoopRequest&) { return kPathFormats; }
[[nodiscard]] inline std::span<const Format> formats_of(const LogmapRequest&) {
  return kArraysOrSurface;
}
[[nodiscard]] inline std::span<const Format> formats_of(const NearestRequest&) { return kJsonOnly; }

}  // namespace geodesic::proto
