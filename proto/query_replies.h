// What each query answers, as values, and their JSON.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/vec3.h"
#include "proto/methods.h"

namespace geodesic::proto {

// A point found on a mesh, in the client's numbers. Every reply echoes the points
// of its request in this form.
struct ResolvedPoint {
  std::optional<std::uint64_t> vertex;  // a source vertex, when it is one
  std::optional<std::uint64_t> face;    // a source face; none at a vertex without faces
  std::array<double, 3> bary{};
  Vec3 xyz;
  double snap_distance = 0;  // from what was asked to what was found, mesh units
};

struct DistanceReply {
  std::string mesh;
  Method method = Method::wavefront;
  std::vector<ResolvedPoint> from;
  std::optional<std::vector<ResolvedPoint>> at;
  std::vector<double> distances;  // one per source vertex, or one per `at`; infinite: unreached
  std::uint64_t reached = 0;      // how many of them are finite
  std::optional<double> max;      // the greatest of them
  std::optional<std::uint64_t> farthest;  // and where: a source vertex, or a place in `at`
};

struct PathReplyPoint {
  Vec3 xyz;
  std::optional<std::uint64_t> face;  // source face of the segment that leaves this point
  std::array<double, 3> bary{};
};

struct PathReply {
  std::string mesh;
  Method method = Method::wavefront;
  ResolvedPoint from;
  ResolvedPoint to;
  bool reachable = false;
  double length = 0;  // mesh units; meaningless when not reachable
  std::vector<PathReplyPoint> points;
};

struct NearestReply {
  std::string mesh;
  std::vector<ResolvedPoint> points;
};

// `digits`: see append_number.
[[nodiscard]] std::string to_json(const DistanceReply& reply, int digits);
[[nodiscard]] std::string to_json(const PathReply& reply, int digits);
[[nodiscard]] std::string to_json(const NearestReply& reply, int digits);
[[nodiscard]] std::string methods_json();

}  // namespace geodesic::proto
