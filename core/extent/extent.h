// How far a surface extends: its diameter, its middle, and how far apart its points are on average.
// Each needs the fields of all vertices, or of few where the triangle inequality bounds the rest:
// from a vertex s with the greatest distance e(s), the greatest distance from any vertex v is at
// least max(d(s, v), e(s) - d(s, v)) and at most e(s) + d(s, v). Takes and Kosters 2011,
// "Determining the diameter of small world networks", whose choice of the next vertex this follows.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/method.h"
#include "core/solve/solve_scratch.h"
#include "core/surface/adjacency.h"

namespace geodesic {

enum class ExtentOf : std::uint8_t {
  diameter,  // the greatest distance between two vertices
  center,    // the vertex from which the greatest distance is least
  median,    // the vertex from which the mean distance over the surface is least
  mean,      // the mean distance between two points of the surface
};

// Of the part of the surface, joined through vertices, that has most vertices. Means are over the
// area, the distance being linear inside each face. Mesh units.
struct Extent {
  double value = 0;  // the best that was found; of a mean its estimate
  // The true one is not outside; of a mean that is not exact, with a confidence of 95 %.
  double lower = 0;
  double upper = 0;
  // Whether the value is that of all vertices: as exact as the method's distances.
  bool is_exact = false;
  std::vector<std::uint32_t> vertices;  // the diameter's ends, the centre or the median
  std::uint64_t fields = 0;             // that were computed
  std::uint64_t part_vertices = 0;
};

// Whether two bounds are equal, to rounding; never where the upper one is infinite.
[[nodiscard]] bool are_met(double lower, double upper);

// At most `fields` fields are computed, at least one. By methods whose distances are no metric
// (MethodTraits) bounds are as uncertain as distances are, and a value counts as exact only with
// the fields of all vertices. A mean is estimated from vertices drawn at random, by the area about
// them; the same ones each time. `upper` is infinite where nothing bounds it: the draws of a mean,
// or a vertex that no field has reached. Errors: cancelled; those of solve_field.
[[nodiscard]] Result<Extent> extent(ExtentOf what, Method method, const MethodOptions& options,
                                    const Adjacency& adjacency, std::uint64_t fields,
                                    SolveScratch& scratch, const Cancel& cancel);

}  // namespace geodesic
