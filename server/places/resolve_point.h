// From a point as a client names it to a place on a mesh, and back.
#pragma once

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/locate/closest_point.h"
#include "core/refine/refinement.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "proto/replies/replies.h"
#include "proto/wire/point_request.h"

namespace geodesic::server {

struct PlacedPoint {
  SurfacePoint point;
  proto::ResolvedPoint echo;  // what the reply says of it
};

// Whether the surface must be searched for it: in a compute slot, for a search may be long.
[[nodiscard]] bool is_searched(const proto::PointRequest& request);

// Whether it lies on a face that welding has dropped. To find the edge that it has become takes as
// long as a vertex has faces, so it belongs into a compute slot, too.
[[nodiscard]] bool is_on_dropped_face(const Mesh& mesh, const proto::PointRequest& request);

// Whether it lies on a face that lines have split: the part that has it is searched for, so it
// belongs into a compute slot, too. `refinement`: null where no face is split.
[[nodiscard]] bool is_on_split_face(const Refinement* refinement,
                                    const proto::PointRequest& request);

// `index` may be null unless the point is searched, `refinement` where no face is split. A point on
// the border between parts of a face is in the one of the least number, and a vertex that walls
// have doubled is that of the side with the face of the least number. Errors: index_out_of_range,
// outside_region (a face that was cut away, or a vertex with no other), snap_too_far, no_hit,
// value_out_of_range, mesh_invalid (a point on a face without surface that touches no other),
// cancelled.
[[nodiscard]] Result<PlacedPoint> resolve_point(const Adjacency& adjacency,
                                                const Refinement* refinement,
                                                const ClosestPointIndex* index,
                                                const proto::PointRequest& request,
                                                const Cancel& cancel);

// What a reply says of a place on the mesh.
[[nodiscard]] proto::ResolvedPoint reply_point(const Mesh& mesh, const Refinement* refinement,
                                               const SurfacePoint& point);

}  // namespace geodesic::server
