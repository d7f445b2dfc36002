// From a point as a client names it to a place on a mesh, and back.
#pragma once

#include <functional>
#include <memory>

#include "core/adjacency.h"
#include "core/closest_point.h"
#include "core/error.h"
#include "core/surface_point.h"
#include "core/trace_path.h"
#include "proto/point_request.h"
#include "proto/query_replies.h"

namespace geodesic::server {

struct PlacedPoint {
  SurfacePoint point;
  proto::ResolvedPoint echo;  // what the reply says of it
};

// Gives the index that finds closest points and hits; called only if one is needed.
using ClosestPoints = std::function<Result<std::shared_ptr<const ClosestPointIndex>>()>;

// Errors: index_out_of_range, snap_too_far, no_hit, value_out_of_range, mesh_invalid
// (a point on a face without surface that touches no other), and those of `closest`.
[[nodiscard]] Result<PlacedPoint> resolve_point(const Adjacency& adjacency,
                                                const ClosestPoints& closest,
                                                const proto::PointRequest& request);

// What a reply says of a place on the mesh.
[[nodiscard]] proto::ResolvedPoint reply_point(const Mesh& mesh, const SurfacePoint& point);

// A point of a path, in the client's numbers.
[[nodiscard]] proto::PathReplyPoint path_reply_point(const Mesh& mesh, const PathPoint& point);

}  // namespace geodesic::server
