// What back_traced_wavefront.h works in.
#pragma once

#include <cstdint>
#include <vector>

#include "core/face_record.h"
#include "core/sight.h"
#include "core/vertex_heap.h"

namespace geodesic {

// Memory that a query works in, kept for the next query on the same thread.
struct BackTracedScratch {
  VertexHeap heap;
  std::vector<double> distance;  // of one of several waves; kUnreached between waves
  std::vector<double> estimate;  // by the paper's rule, what the order follows
  std::vector<Halfedge> base;    // the edge opposite the vertex that the estimate is over
  std::vector<std::uint8_t> is_target;
  std::vector<Wedge> wedges;
};

}  // namespace geodesic
