// The closest point of a surface to a point in space, and the first on a ray.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

struct ClosestPoint {
  SurfacePoint point;
  double distance;  // mesh units
};

struct RayHit {
  SurfacePoint point;
  double distance;  // from the ray's origin, mesh units
};

// A bounding volume hierarchy over the faces of a mesh, built once and shared.
// The hierarchy finds faces that may be meant (face_hierarchy.h): Embree, where the engine was
// built with it. What they mean, distances and hits, is computed here in double precision, so
// that answers do not depend on the hierarchy.
class ClosestPointIndex {
 public:
  enum class Hierarchy : std::uint8_t {
    quickest,  // Embree's, where the engine was built with it
    boxes,     // the engine's own: slower
  };

  explicit ClosestPointIndex(std::shared_ptr<const Adjacency> adjacency);
  // Errors: cancelled.
  [[nodiscard]] static Result<std::shared_ptr<const ClosestPointIndex>> build(
      std::shared_ptr<const Adjacency> adjacency, const Cancel& cancel,
      Hierarchy hierarchy = Hierarchy::quickest);
  ~ClosestPointIndex();
  ClosestPointIndex(const ClosestPointIndex&) = delete;
  ClosestPointIndex& operator=(const ClosestPointIndex&) = delete;

  // `from` must be finite and no component beyond Mesh::kMaxCoordinate. Among faces at the same
  // distance the one of the lower number is taken (from far away: far_search.h). From the middle
  // of a sphere all faces are as far, and each is looked at; elsewhere few are, however far
  // away `from` is. Any number of threads may ask at once.
  [[nodiscard]] ClosestPoint closest(Vec3 from) const;
  // Errors: cancelled.
  [[nodiscard]] Result<ClosestPoint> closest(Vec3 from, const Cancel& cancel) const;

  // The first point of the surface that a ray meets, from either side of a face;
  // nothing if it misses. Both must be finite and no component beyond
  // Mesh::kMaxCoordinate; the direction must not be zero, and need not have length
  // one. An origin on the surface is its own hit, up to rounding. No ray slips
  // through an edge or a vertex between faces. A face without area is no hit of its
  // own: where faces on its sides have an area, one of those is; otherwise the ray
  // goes on, as it does past a face that it sees edge-on. Any number of threads may
  // ask at once.
  [[nodiscard]] std::optional<RayHit> first_hit(Vec3 origin, Vec3 direction) const;
  // Errors: cancelled.
  [[nodiscard]] Result<std::optional<RayHit>> first_hit(Vec3 origin, Vec3 direction,
                                                        const Cancel& cancel) const;

  // Memory held, without the mesh.
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Scene;
  ClosestPointIndex(std::shared_ptr<const Adjacency> adjacency, const Cancel& cancel,
                    Hierarchy hierarchy);
  std::shared_ptr<const Adjacency> adjacency_;
  std::unique_ptr<Scene> scene_;
};

}  // namespace geodesic
