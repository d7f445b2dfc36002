// What back_traced/wavefront.h works in.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/back_traced/crowded_edges.h"
#include "core/back_traced/visibility_cones.h"
#include "core/field/field.h"
#include "core/field/vertex_buckets.h"
#include "core/surface/face_record.h"

namespace geodesic {

// What a front knows of a vertex, besides its distance. A quarter of a cache line.
struct FrontVertex {
  double estimate = kUnreached;  // by the paper's rule; times -1 once it has its distance
  Halfedge base = kNone;         // opposite the vertex, what the estimate is over; or kNone:
                                 // straight from the source
  float crossing = 0;            // where its way crosses that, as in arrive_lanes.h

  [[nodiscard]] bool is_accepted() const { return std::signbit(estimate); }
};

// Memory that a query works in, kept for the next query on the same thread.
struct BackTracedScratch {
  struct Ask {
    std::uint32_t place;  // in the round
    double best;          // before it asked
  };

  VertexBuckets waiting;
  std::vector<FrontVertex> vertices;
  // Whether all of them are as constructed, as a finished query leaves them.
  bool is_clean = false;
  std::vector<std::uint32_t> visited;
  std::vector<double> distance;  // of one of several waves; kUnreached between waves
  std::vector<std::uint8_t> is_target;
  std::vector<VisibilityCone> cones;
  CrowdedEdges crowds;
  // Of those that are accepted together.
  std::vector<std::uint32_t> round;
  std::vector<double> best;
  std::vector<std::uint32_t> corners;
  std::vector<Halfedge> bases;
  std::vector<Ask> asks;  // which vertex of the round each of `bases` belongs to
};

}  // namespace geodesic
