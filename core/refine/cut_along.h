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

// The line with a point added in the middle of each segment, as refine_along is to have it. The two
// ends of a cut stay shared by its sides, so a cut of a single edge would cut nothing. Of no use if
// the poll says to stop.
[[nodiscard]] SurfacePolyline as_wall(const Adjacency& adjacency, const SurfacePolyline& line,
                                      Poll& poll);

// The faces that are left, with the edges of the chains at `walls` cut: paths go along a cut and
// round its ends, where these are inside the surface, and do not cross it. The faces
// about a vertex of a cut fall into groups that edges still join. Each group gets a copy of the
// vertex. A group that no cut divides and that met the others in this vertex alone, as in a bowtie,
// keeps the first copy.
// Lines of `walls` are such as as_wall makes. `is_left`: by face of the refined mesh; not 0 for
// those that stay. Errors: no_triangles (no face is left), too_much_memory, those of
// RefinedSoup::build, cancelled.
[[nodiscard]] Result<CutMesh> cut_along(const RefinedMesh& refined,
                                        std::span<const std::uint32_t> walls,
                                        std::span<const std::uint8_t> is_left,
                                        const Cancel& cancel);

}  // namespace geodesic
