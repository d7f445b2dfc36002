// The mesh with its faces split so that polylines on it are chains of its edges.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "core/refine/refinement.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

struct RefinedMesh {
  // Its source vertices and faces are those of the whole's file. A new vertex has a source number
  // of its own, from source_vertex_count() on. All parts of a source face name it in
  // `source_of_face`; `face_of_source` names the first of them.
  Mesh mesh;
  Refinement refinement;
  // By polyline: vertices of the mesh, each joined to the next by an edge, no two in a row the
  // same. One vertex for a polyline that is all at one place.
  std::vector<std::vector<std::uint32_t>> chains;
};

// The points of a line. Two in a row lie in one face, and the line is straight between them. Or
// only faces without width lie between them: shortest paths leave those out. The line is closed if
// its last point is where its first is. It may run through vertices and along edges, and touch and
// cross itself and others.
using SurfacePolyline = std::vector<SurfacePoint>;

// A point nearer than 1e-9 of a face (of an edge's length, of a height) to a vertex or an edge is
// taken to be there; one inside a face nearer than 2e-9 to an earlier one is taken to be that.
// Faces that no line crosses stay as they are. Where the file has a face several times, lines split
// all of them alike, with the same new vertices. Errors: value_out_of_range (two points in a row in
// no face together, an empty line), too_large (more than `most_vertices` new ones),
// too_much_memory, those of RefinedSoup::build, cancelled.
[[nodiscard]] Result<RefinedMesh> refine_along(const Adjacency& whole,
                                               std::span<const SurfacePolyline> lines,
                                               std::uint64_t most_vertices, const Cancel& cancel);

}  // namespace geodesic
