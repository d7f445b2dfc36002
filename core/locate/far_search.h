// The closest point of a mesh to a point far from it.
//
// From far away, all faces are about equally far. The farther the point is, the worse distances
// tell the faces apart: in single precision not at all beyond 1e5 sizes of the mesh. So the search
// does not compare distances. For q = D u, with |u| = 1, from the middle of the mesh,
//
//   |q - x|^2 = D^2 + 2 D h(x),   h(x) = |x|^2 / (2 D) - u.x
//
// and h is about as large as the mesh, whatever D is. If D is so large that |x|^2 / (2 D) is lost
// in rounding, h is least at the corner farthest along u.
//
// The least value of h in a box is the sum of the least values of its three coordinates' terms.
#pragma once

#include <cstdint>

#include "core/base/cancel.h"
#include "core/base/vec3.h"
#include "core/locate/closest_on_triangle.h"
#include "core/locate/face_boxes.h"
#include "core/locate/unit_box.h"
#include "core/mesh/mesh.h"

namespace geodesic {

class FarSearch {
 public:
  // All must outlive it.
  FarSearch(const Mesh& mesh, const UnitBox& unit, const FaceBoxes& boxes)
      : mesh_(mesh), unit_(unit), boxes_(boxes) {}

  struct Found {
    std::uint32_t face = kNone;  // kNone: cancelled
    TriangleWeights bary{1, 0, 0};
  };
  // `q` is in the frame of `unit`, outside of the box that the mesh fills there. If the closest
  // point is a vertex, its face of the lowest number is found. If it is on an edge, rounding may
  // decide which of the edge's faces is found.
  [[nodiscard]] Found closest(Vec3 q, const Cancel& cancel) const;

 private:
  struct Query;

  const Mesh& mesh_;
  const UnitBox& unit_;
  const FaceBoxes& boxes_;
};

}  // namespace geodesic
