// A refined mesh cut along chains of its edges: no path crosses them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "core/refine/refine_along.h"
#include "core/refine/refinement.h"
#include "core/surface/adjacency.h"

namespace geodesic {

struct CutMesh {
  // As RefinedMesh::mesh. Vertices that the cuts have doubled have the same source vertex; where
  // that is (`vertex_of_source`) is the side with the face of the least number in the file.
  Mesh mesh;
  Refinement refinement;
};

// A line as it is to be refined along to be cut: with a point in the middle of each segment. A cut
// ends in a vertex that both its sides have; an edge with two such ends would not be cut at all.
// Of no use if the poll says to stop.
[[nodiscard]] SurfacePolyline as_wall(const Adjacency& adjacency, const SurfacePolyline& line,
                                      Poll& poll);

// The faces that are left, with the edges of the chains at `walls` cut: paths go along a cut and
// round its ends, where these are inside the surface, and do not cross it. A vertex of a cut
// becomes as many as its faces fall into groups that are still joined there by edges. A group that
// no cut divides and that the others touched in that vertex alone, as in a bowtie, stays with the
// first of them.
// Lines of `walls` are such as as_wall makes. `is_left`: by face of the refined mesh; not 0 for
// those that stay. Errors: no_triangles (no face is left), those of Mesh::build, cancelled.
[[nodiscard]] Result<CutMesh> cut_along(const RefinedMesh& refined,
                                        std::span<const std::uint32_t> walls,
                                        std::span<const std::uint8_t> is_left,
                                        const Cancel& cancel);

}  // namespace geodesic
