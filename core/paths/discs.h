// What a geodesic disc measures: the surface no farther from the sources than a radius. As for
// isolines (isolines.h), a field is taken as linear inside each face. Areas and lengths are then
// those of polygons, to rounding; against the smooth disc they are off by the square of the edges'
// length over the radius. A disc that is smaller than the faces round its source is not seen.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// The surface whose distance is at most `radius`; all lengths and areas in mesh units. Faces with
// an unreached vertex are no part of any disc.
struct Disc {
  double radius = 0;
  double area = 0;
  double mean = 0;       // of the distance over the disc; 0 where there is no area
  double perimeter = 0;  // of the isolines at the radius
  // Of the surface's boundary inside the disc. What runs along an isoline is part of that.
  double boundary = 0;
  std::uint64_t lines = 0;     // the isolines at the radius
  std::uint64_t vertices = 0;  // source vertices no farther than the radius
  // Euler characteristic: 1 of a disc that folds over nowhere, 0 of a ring, 2 of a whole sphere.
  // Where a surface is linear the part below a level can be shrunk to the vertices, edges and
  // faces that are wholly in it (Edelsbrunner, Harer, "Computational Topology", 2010, VI.3), which
  // are counted.
  std::int64_t euler = 0;
  bool is_whole = false;  // every vertex that is in a face is in the disc
};

struct Discs {
  std::vector<Disc> discs;
  std::uint64_t crossings = 0;  // of faces by isolines at the radii
};

// A disc for each of the radii, which must ascend, each once. O(f log r + s) for f faces, r radii
// and s crossings. Errors: cancelled.
[[nodiscard]] Result<Discs> measure_discs(const Adjacency& adjacency, const Field& field,
                                          std::span<const double> radii, const Cancel& cancel);

}  // namespace geodesic
