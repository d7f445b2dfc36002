// The closest point of a mesh to a point far from it.
//
// Seen from far away all faces are about equally far, and distances tell them apart the worse
// the farther the point is: in single precision not at all beyond 1e5 sizes of the mesh. So not
// distances are compared. For q = D u, with |u| = 1, from the middle of the mesh,
//
//   |q - x|^2 = D^2 + 2 D h(x),   h(x) = |x|^2 / (2 D) - u.x
//
// and h is of the size of the mesh whatever D is. Where D is infinite for all that numbers tell,
// its least value is in the corner farthest along u.
//
// Faces follow a space-filling curve, so that the boxes of so many faces in a row, and of so
// many of those boxes, are a hierarchy that needs no pointers: the least value of h in a box is
// the sum of those of its three coordinates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cancel.h"
#include "core/closest_on_triangle.h"
#include "core/mesh.h"
#include "core/ray_search.h"
#include "core/vec3.h"

namespace geodesic {

class FarSearch {
 public:
  // `mesh` and `unit` must outlive it. Looks at each face once; of no use once the poll says
  // to stop.
  FarSearch(const Mesh& mesh, const UnitBox& unit, Poll& poll);

  struct Found {
    std::uint32_t face = kNone;  // kNone: cancelled
    TriangleWeights bary{1, 0, 0};
  };
  // `q` in the frame of `unit`, and not inside of the box that the mesh fills there. Of faces that
  // h does not tell apart, the one of the lowest number at a vertex, and one of them at an edge.
  [[nodiscard]] Found closest(Vec3 q, const Cancel& cancel) const;

  // Memory held, without the mesh.
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Query;
  void search(Query& query, std::size_t level, std::size_t block) const;

  const Mesh& mesh_;
  const UnitBox& unit_;
  std::vector<std::vector<Box>> levels_;  // the first has one box for so many faces
};

}  // namespace geodesic
