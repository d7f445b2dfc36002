// What regions with lines leave of a mesh: walls are cut, and faces that lines cross are split.
#pragma once

#include <memory>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/locate/closest_point.h"
#include "core/mesh/mesh.h"
#include "core/refine/cut_along.h"
#include "core/surface/adjacency.h"
#include "proto/region/cut_regions.h"
#include "proto/region/region.h"

namespace geodesic::server {

// Whether a point of a line must be searched for, by an index of the whole.
[[nodiscard]] bool has_searched_points(const proto::Regions& regions);

// `index`: of the whole; may be null unless points are searched. In the slot of a computation, for
// paths between points of lines are searched for. Errors: those of resolve_point and cut_regions;
// value_out_of_range (no way between two points of a line; a line without an inside), too_large
// (lines that cross too many edges), each naming the parameter; cancelled.
[[nodiscard]] Result<CutMesh> cut_lines(const Adjacency& whole, const ClosestPointIndex* index,
                                        const proto::Regions& regions, const proto::FileFaces& file,
                                        const Cancel& cancel);

}  // namespace geodesic::server
