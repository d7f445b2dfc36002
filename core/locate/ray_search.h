// The first face that a ray meets, of those it is shown one after the other. Which
// to show is for a hierarchy to say (face_hierarchy.h); the arithmetic is here, in
// double precision.
//
// It takes place in a frame in which the mesh fills the box [-1, 1]: neither a huge
// nor a tiny mesh overflows it. A ray that begins far away is first moved up to the
// box, so that what rounding takes is small against the mesh, not against the way.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/base/cancel.h"
#include "core/base/vec3.h"
#include "core/locate/ray_triangle.h"
#include "core/locate/unit_box.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

class RaySearch {
 public:
  // `direction` as ClosestPointIndex::first_hit takes it. Nothing if the ray misses
  // the box.
  [[nodiscard]] static std::optional<RaySearch> begin(const Adjacency& adjacency,
                                                      const UnitBox& unit, Vec3 origin,
                                                      Vec3 direction);

  // Where the search begins, in the frame, and the direction there, whose largest
  // component is 1 or -1.
  [[nodiscard]] Vec3 origin() const { return unit_->inside(origin_); }
  [[nodiscard]] Vec3 direction() const { return direction_; }

  // True when the face is met before all others so far. Of faces met at once the one
  // of the lowest number is kept, whatever the order in which they are shown. Of no
  // use if the poll says to stop.
  bool consider(std::uint32_t face, Poll& poll);

  // How far the first hit is, in lengths of direction(); infinite without one.
  [[nodiscard]] double reach() const { return reach_; }
  [[nodiscard]] std::optional<SurfacePoint> hit() const;

 private:
  RaySearch(const Adjacency& adjacency, const UnitBox& unit, Vec3 origin, Vec3 direction)
      : adjacency_(&adjacency),
        unit_(&unit),
        origin_(origin),
        direction_(direction),
        frame_(direction) {}

  // Of the faces on the edge of a side, whose own face has no area, the next in the ring
  // that has one, as its halfedge there; or where a crowd of others comes first, the lowest.
  // kNone where there is none.
  [[nodiscard]] Halfedge side_with_area(Halfedge side, Poll& poll);

  struct CrowdedEdge {
    std::uint32_t low = kNone;  // its vertices
    std::uint32_t high = kNone;
    Halfedge side = kNone;  // the lowest there of a face with an area
  };

  const Adjacency* adjacency_;
  const UnitBox* unit_;
  Vec3 origin_;  // mesh units
  Vec3 direction_;
  RayFrame frame_;
  double reach_ = std::numeric_limits<double>::infinity();
  std::uint32_t met_ = kNone;   // the face that was met
  std::uint32_t face_ = kNone;  // and the one to say it of: another where that has no area
  std::array<double, 3> bary_{};
  // Those gone round last. A fixed number, since from Embree's callback nothing may be thrown.
  std::array<CrowdedEdge, 8> crowded_{};
  std::size_t next_crowded_ = 0;
};

}  // namespace geodesic
