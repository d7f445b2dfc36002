// Of how many parts a surface consists, and how many loops its boundary has.
#pragma once

#include <cstdint>

#include "core/base/cancel.h"
#include "core/surface/triangulation.h"

namespace geodesic {

struct SurfaceParts {
  std::uint64_t components = 0;  // of faces, joined through vertices
  // Cycles of boundary edges, where each is followed by the one that ends the same fan of faces. A
  // fan that ends at a non-manifold edge has no successor; its chain counts as a loop of its own.
  std::uint64_t boundary_loops = 0;
};

// `boundary_edges`: how many edges are in one face only. Of no use if the poll says to stop.
[[nodiscard]] SurfaceParts count_parts(const Triangulation& surface, std::uint64_t boundary_edges,
                                       Poll& poll);

}  // namespace geodesic
