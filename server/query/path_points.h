// The points of a path as a reply tells of them.
#pragma once

#include <vector>

#include "core/paths/path.h"
#include "core/refine/refinement.h"
#include "core/surface/adjacency.h"
#include "proto/replies/replies.h"

namespace geodesic::server {

// Each in the face of the segment that leaves it, the last one in that of the segment that comes
// to it. A segment along an edge is in all of the edge's faces: then the one of the least number
// in the file is named, whichever the search came through.
// `refinement`: null where no face is split; parts of a face are told of as the face.
[[nodiscard]] std::vector<proto::PathReplyPoint> path_points(const Adjacency& adjacency,
                                                             const Refinement* refinement,
                                                             const Path& path);

}  // namespace geodesic::server
