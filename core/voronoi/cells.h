// What the cells of the nearest site measure, and where their middles are.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "core/voronoi/near_sites.h"

namespace geodesic {

// All that is nearer to one site than to the others; lengths and areas in mesh units.
struct VoronoiCell {
  double area = 0;
  double perimeter = 0;        // of its bisectors with other cells
  double boundary = 0;         // of the surface's boundary in it
  std::uint64_t vertices = 0;  // source vertices; of copies, the nearest counts
  // The mean position of the cell, and the point of the cell that is nearest to it; of no use where
  // there is no area.
  Vec3 mean;
  SurfacePoint centroid;

  [[nodiscard]] bool is_empty() const { return !(area > 0); }
};

// Area, vertices, mean and centroid of each of `sites` cells. The areas add up to that of all faces
// whose corners are reached. O(f) for f faces, and what it takes to divide them (face_cells.h).
// Errors: cancelled.
//
// The centroid is the constrained mass centroid of Du, Gunzburger, Ju 2003, "Constrained
// centroidal Voronoi tessellations for surfaces", SIAM Journal on Scientific Computing 24(5): of
// all points of the cell the one from which the mean squared distance in space to the cell is
// least. That is the one nearest to the mean position; of several, that in the first face.
[[nodiscard]] Result<std::vector<VoronoiCell>> measure_cells(const Adjacency& adjacency,
                                                             const NearSites& near,
                                                             std::uint32_t sites,
                                                             const Cancel& cancel);

}  // namespace geodesic
