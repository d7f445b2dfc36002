// The mesh with its faces split so that polylines on it are chains of its edges.
#pragma once

#include <cstdint>
#include <optional>
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
  // In the numbers of the same file: its source vertices and faces are those of the whole. A vertex
  // that is none of the file's has `source_of_vertex` of source_vertex_count() and more, each
  // another one. All parts of a source face have it as their `source_of_face`; its
  // `face_of_source` is the first of them.
  Mesh mesh;
  Refinement refinement;
  // By polyline: vertices of the mesh, each joined to the next by an edge, no two in a row the
  // same. One vertex for a polyline that is all at one place.
  std::vector<std::vector<std::uint32_t>> chains;
};

// A line from point to point; two in a row lie in one face, and what is between them is straight
// there; or only faces without width lie between their faces, as paths leave such faces out. Closed
// where the last is at the place of the first. May run through vertices and along edges, and touch
// and cross itself and others.
using SurfacePolyline = std::vector<SurfacePoint>;

// A point nearer than 1e-9 of a face (of an edge's length, of a height) to a vertex or an edge, or
// to one before it, is taken to be there. Faces that no line crosses stay as they are.
// Errors: value_out_of_range (two points in a row in no face together, an empty line), too_large
// (more than `most_vertices` new ones), those of Mesh::build, cancelled.
[[nodiscard]] Result<RefinedMesh> refine_along(const Adjacency& whole,
                                               std::span<const SurfacePolyline> lines,
                                               std::uint64_t most_vertices, const Cancel& cancel);

}  // namespace geodesic
