// A distance field over the vertices of a mesh, and where each value came from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/mesh.h"
#include "core/surface_point.h"

namespace geodesic {

inline constexpr double kUnreached = std::numeric_limits<double>::infinity();

// A place where distances start, at `offset` instead of zero.
struct Source {
  SurfacePoint point;
  double offset = 0;  // mesh units, not negative
};

// The two vertices from which a vertex's distance was computed (Tang et al.
// 2007, section 3.3). Three special forms:
//   {kNone, kNone}    not reached;
//   {kNone, s}        straight from source number s, within one face;
//   {v, v}            along the edge from v.
struct Parents {
  std::uint32_t first = kNone;
  std::uint32_t second = kNone;

  [[nodiscard]] bool from_source() const { return first == kNone && second != kNone; }
  [[nodiscard]] bool along_edge() const { return first == second && first != kNone; }
};

// As in the paper, a vertex costs one number for its distance and two for its
// parents: 16 bytes.
struct Field {
  std::vector<Source> sources;
  std::vector<double> distance;  // per vertex, mesh units; kUnreached where there is none
  std::vector<Parents> parents;  // per vertex
  // Per vertex the number of the source that its distance is from, kNone where
  // there is none. Empty for a single source.
  std::vector<std::uint32_t> nearest_source;
  std::uint64_t reached = 0;       // vertices with a distance
  double max = 0;                  // the greatest distance
  std::uint32_t farthest = kNone;  // the vertex that has it

  // Whether distances at two vertices that both have one are from the same source.
  [[nodiscard]] bool same_source(std::uint32_t a, std::uint32_t b) const {
    return nearest_source.empty() || nearest_source[a] == nearest_source[b];
  }

  [[nodiscard]] std::size_t bytes() const {
    return sizeof(Field) + nearest_source.capacity() * sizeof(std::uint32_t) +
           sources.capacity() * sizeof(Source) + distance.capacity() * sizeof(double) +
           parents.capacity() * sizeof(Parents);
  }
};

}  // namespace geodesic
