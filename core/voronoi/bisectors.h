// Where cells meet: lines that are as far from two sites, and the points that are as far from
// three.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "core/voronoi/cells.h"
#include "core/voronoi/near_sites.h"

namespace geodesic {

// A polyline between two cells whose every segment lies in one face.
struct Bisector {
  std::array<std::uint32_t, 2> sites{};  // ascending
  bool closed = false;       // then a last segment leads from the last point to the first
  double length = 0;         // mesh units, that segment included
  std::vector<Vec3> points;  // at least two, and no two in a row are equal
};

// Where three cells meet: a triangle of the geodesic Delaunay triangulation.
struct VoronoiVertex {
  // Round the point as the corners of its face.
  std::array<std::uint32_t, 3> sites{};
  SurfacePoint point;
  Vec3 position;
  double distance = 0;  // from all three, mesh units
};

struct Bisectors {
  std::vector<Bisector> lines;          // by their sites, then by the first face that they cross
  std::vector<VoronoiVertex> vertices;  // by face
  std::uint64_t segments = 0;
};

// Fills in perimeters and boundaries of the cells. Lines end where three cells meet, where the
// surface does, and at edges with three faces or more, where several of them meet. So do those
// along the common border of sites that are faces, at whose ends there is no VoronoiVertex.
//
// O(f + s log s) for f faces and s segments, and what it takes to divide the faces (face_cells.h).
// Errors: cancelled; too_large (more segments than `max_segments`).
[[nodiscard]] Result<Bisectors> trace_bisectors(const Adjacency& adjacency, const NearSites& near,
                                                std::uint64_t max_segments,
                                                std::span<VoronoiCell> cells, const Cancel& cancel);

}  // namespace geodesic
