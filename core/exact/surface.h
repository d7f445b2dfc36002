// Which faces windows run over: those of the mesh, or those of its intrinsic Delaunay
// triangulation. Vertices have the same distances on both; what differs is how many edges
// lie in the way.
#pragma once

#include <span>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "core/surface/triangulation.h"

namespace geodesic::exact {

// The one on which straight lines away from the sources cross fewer edges, or nearly so.
// Estimated as in Cauchy's and Crofton's formula: lines with the direction u across a face
// cross its side e in proportion to |e x u|, those of any direction to |e| 2 / pi. On the mesh
// u is taken straight away from the nearest source in space; a Delaunay triangulation has no
// directions to speak of. The faces of the mesh if the poll says to stop.
[[nodiscard]] Triangulation surface_for_windows(const Adjacency& adjacency,
                                                std::span<const Source> sources, Poll& poll);

}  // namespace geodesic::exact
