// The distances at the points that `steiner` adds to the edges.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/field/travel_cost.h"

namespace geodesic {

// Point i of an edge lies at (i + 1) / (per_edge + 1) of its length, counted from
// the end with the smaller vertex number. Point i of edge e is number
// e * per_edge + i.
struct EdgePoints {
  std::uint32_t per_edge = 0;
  std::vector<std::uint32_t> edge_of;  // by halfedge 4f + c: the number of its edge
  std::vector<double> distance;        // by point, mesh units; kUnreached where there is none
  std::vector<std::uint32_t> nearest_source;  // by point; empty for a single source
  // Where distances are costs: what they are of, and by node the one before it on the cheapest way,
  // kNone where that comes straight from a source. Nodes are the vertices, then the points.
  std::shared_ptr<const TravelCost> cost;
  std::vector<std::uint32_t> before;

  [[nodiscard]] std::size_t bytes() const {
    return sizeof(EdgePoints) + edge_of.capacity() * sizeof(std::uint32_t) +
           distance.capacity() * sizeof(double) +
           nearest_source.capacity() * sizeof(std::uint32_t) +
           before.capacity() * sizeof(std::uint32_t) + (cost ? cost->bytes() : 0);
  }
};

}  // namespace geodesic
