// How far each vertex is from the rest of the surface on average: small in the middle, great at the
// ends. In graphs this is the closeness of a vertex, estimated by distances from a few others as
// here: Eppstein and Wang 2004, "Fast approximation of centrality".
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/method.h"
#include "core/solve/solve_scratch.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Of the part of the surface, joined through vertices, that has most vertices. Means are over the
// area, the distance being linear inside each face. Mesh units.
struct MeanDistances {
  // By vertex; kUnreached outside of the part.
  std::vector<double> mean;
  // What is to be added to either side of each mean for a confidence of 95 % that the true one is
  // between: of that vertex, not of all at once. 0 if the means are from the fields of all
  // vertices. Infinite where the draws say nothing of it.
  std::vector<double> margin;
  // The mean distance between two points of the surface, and its bounds with the same confidence.
  double overall = 0;
  double lower = 0;
  double upper = 0;
  bool is_exact = false;     // from the fields of all vertices: as exact as the method's distances
  std::uint64_t fields = 0;  // that were computed
  std::uint64_t part_vertices = 0;
};

// At most `fields` fields are computed, at least one: of all vertices of the part that have
// an area about them if there are no more, else of vertices drawn at random by the area about them,
// the same ones each time. A distance is taken to be as long either way. Errors: cancelled; those
// of solve_field.
[[nodiscard]] Result<MeanDistances> mean_distances(Method method, const MethodOptions& options,
                                                   const Adjacency& adjacency, std::uint64_t fields,
                                                   SolveScratch& scratch, const Cancel& cancel);

}  // namespace geodesic
