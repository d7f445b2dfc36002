// The part of a surface that the shortest path between two points lies in, as a mesh of
// its own: for methods that cost much more a vertex than cutting it out does.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

class SurfacePatch {
 public:
  // All faces with a point from which the straight lines in space to `from` and to `to`
  // are together no longer than `longest`, the length of a path between the two. No path
  // that is as short leaves these faces, so the shortest is the same here.
  // Errors: cancelled.
  [[nodiscard]] static Result<SurfacePatch> cut(const Adjacency& adjacency,
                                                const SurfacePoint& from, const SurfacePoint& to,
                                                double longest, const Cancel& cancel);

  // Nothing was cut out: the patch would have all of the surface's faces, or none.
  [[nodiscard]] bool is_whole() const { return adjacency_ == nullptr; }
  // Only if it is not whole.
  [[nodiscard]] const Adjacency& adjacency() const { return *adjacency_; }

  // A point of the surface, there. Nothing if no face of the patch has it, as none has a vertex
  // that is in no face. Only if it is not whole.
  [[nodiscard]] std::optional<SurfacePoint> inside(const SurfacePoint& point) const;
  // A path over the patch, on the whole surface.
  void bring_back(Path& path) const;

 private:
  std::unique_ptr<const Adjacency> adjacency_;
  std::vector<std::uint32_t> faces_;     // of the whole surface, by the patch's source faces
  std::vector<std::uint32_t> vertices_;  // the same
};

}  // namespace geodesic
