// Gaps in lines that shortest paths leave, at faces without width.
#pragma once

#include <vector>

#include "core/base/cancel.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// Shortest paths leave out points that are where the one before is: those on the sides of faces
// without width, as CAD programs export along a side that has more vertices on its other face. So
// two points of a path may have no face in common.
//
// The same line with the points that it has left out: each two in a row have a face in common,
// unless there is no way between them at the place of the one and at that of the other, but for
// 1e-9 of a face's longest side. Of no use if the poll says to stop.
[[nodiscard]] std::vector<SurfacePoint> close_gaps(const Adjacency& adjacency,
                                                        const std::vector<SurfacePoint>& line,
                                                        Poll& poll);

}  // namespace geodesic
