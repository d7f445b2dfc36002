// The closest point of a surface to a point in space.
#pragma once

#include <cstddef>
#include <memory>

#include "core/adjacency.h"
#include "core/surface_point.h"
#include "core/vec3.h"

namespace geodesic {

struct ClosestPoint {
  SurfacePoint point;
  double distance;  // mesh units
};

// A bounding volume hierarchy over the faces of a mesh, built once and shared.
// Embree holds and searches the hierarchy in single precision, with a margin; the
// distances themselves are ours, in double precision.
class ClosestPointIndex {
 public:
  explicit ClosestPointIndex(std::shared_ptr<const Adjacency> adjacency);
  ~ClosestPointIndex();
  ClosestPointIndex(const ClosestPointIndex&) = delete;
  ClosestPointIndex& operator=(const ClosestPointIndex&) = delete;

  // `from` must be finite. Among faces at the same distance the one of the lower
  // number is taken. Any number of threads may ask at once.
  [[nodiscard]] ClosestPoint closest(Vec3 from) const;

  // Memory held, without the mesh.
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Scene;
  std::shared_ptr<const Adjacency> adjacency_;
  std::unique_ptr<Scene> scene_;
};

}  // namespace geodesic
