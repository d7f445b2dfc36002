// Places that are one and the same, joined by faces without width; and the gaps at such faces in
// lines that shortest paths leave.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// Every face that has the point's position, with its weights there: those of in_all_faces, then
// those that are reached from it over faces without width, as far as these go, at places that
// rounding alone tells from the point. A way over the surface may leave the point by each of them.
// At a vertex those of in_all_faces alone. Of no use if the poll says to stop.
[[nodiscard]] std::vector<SurfacePoint> in_all_faces_at(const Adjacency& adjacency,
                                                        const SurfacePoint& point, Poll& poll);

// A face that has both points, or kNone; that of the first, if it has. Of no use if the poll says
// to stop.
[[nodiscard]] std::uint32_t face_in_common(const Adjacency& adjacency, const SurfacePoint& a,
                                           const SurfacePoint& b, Poll& poll);

// Where a place that is next to a vertex is put: there; or right beside it on an edge, so that a
// strip of faces leads over it; or wherever it is.
enum class Gaps : std::uint8_t { at_vertices, beside_vertices, anywhere };

// Shortest paths leave out points that are where the one before is: those on the sides of faces
// without width, as CAD programs export along a side that has more vertices on its other face. So
// two points of a path may have no face in common.
//
// The same line with the points that it has left out: each two in a row have a face in common,
// unless no chain of faces joins them within 1e-9 of a face's longest side of the one point or of
// the other. Of no use if the poll says to stop.
[[nodiscard]] std::vector<SurfacePoint> close_gaps(const Adjacency& adjacency,
                                                   const std::vector<SurfacePoint>& line, Gaps gaps,
                                                   Poll& poll);

}  // namespace geodesic
