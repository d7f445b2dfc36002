// Geodesic Voronoi diagrams: for each of some sites the surface that is nearer to it than to the
// others; and Lloyd's way to sites that lie in the middle of their cells.
//
// Where cells end is as right as distances at vertices: in between, see face_cells.h. Where both
// sites are seen straight over faces laid into a plane, bisectors are straight lines and right to
// rounding; elsewhere they are off by the square of the edges' length over the distance. A cell
// need hold no vertex, and a face may have parts of any number of cells.
//
// Sites may be lines and faces, too. Squared distances from these do not differ by linear
// functions: between a line and a point a bisector is a parabola. Bisectors are off by the square
// of the edges' length over the distance then, and where lines are nearer to each other than the
// edges are long, by an edge.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/method.h"
#include "core/solve/solve_field.h"
#include "core/surface/adjacency.h"
#include "core/voronoi/bisectors.h"
#include "core/voronoi/cells.h"
#include "core/voronoi/near_sites.h"

namespace geodesic {

// Of two cells that have a bisector.
struct NeighbourCells {
  std::array<std::uint32_t, 2> sites{};  // ascending
  double length = 0;                     // of all their bisectors, mesh units
};

struct Voronoi {
  std::vector<VoronoiCell> cells;  // by site
  Bisectors bisectors;
  std::vector<NeighbourCells> neighbours;  // by sites
  std::shared_ptr<const NearSites> near;   // what the cells in each face follow from
};

// Of the sources of `field`, which is by this method. What no site reaches is in no cell. Of
// several sites in one place the first has the cell, and the others have none.
//
// As many fields as sites, each a little larger than its cell; but each looks at every vertex once,
// so that s sites on n vertices take O(s n) besides. Errors: those of near_sites and
// trace_bisectors.
[[nodiscard]] Result<Voronoi> voronoi(Method method, const MethodOptions& options,
                                      const Adjacency& adjacency, const Field& field,
                                      std::uint64_t max_segments, SolveScratch& scratch,
                                      const Cancel& cancel);

// The same of points, lines and faces (near_sites.h). Where several are as near, as beyond a common
// end of two lines, the first has the cell.
[[nodiscard]] Result<Voronoi> voronoi(Method method, const MethodOptions& options,
                                      const Adjacency& adjacency, const Field& field,
                                      const VoronoiSites& sites, std::uint64_t max_segments,
                                      SolveScratch& scratch, const Cancel& cancel);

// Moves each site to its cell's centroid (cells.h), `rounds` times, or until none moves: Lloyd
// 1982, "Least squares quantization in PCM", IEEE Transactions on Information Theory 28(2). Sites
// without a cell stay. Errors: those of solve_field.
[[nodiscard]] Result<std::vector<Source>> relax_sites(Method method, const MethodOptions& options,
                                                      const Adjacency& adjacency,
                                                      std::vector<Source> sites,
                                                      std::uint64_t rounds, SolveScratch& scratch,
                                                      const Cancel& cancel);

// A piece of a cell, wound as the face in which it lies.
struct CellTriangle {
  std::uint32_t site;
  std::uint32_t face;
  std::array<Vec3, 3> corners;
};

// The cells cut out of the surface, a triangle after the other, by face. Errors: cancelled.
[[nodiscard]] Result<void> each_cell_triangle(const Adjacency& adjacency, const NearSites& near,
                                              const std::function<void(const CellTriangle&)>& take,
                                              const Cancel& cancel);

}  // namespace geodesic
