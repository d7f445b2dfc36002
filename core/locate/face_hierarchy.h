// What shows a search the faces that may be meant, without looking at all of them. What they mean,
// distances and hits, is for the search to compute.
#pragma once

#include <cstddef>
#include <memory>

#include "core/base/cancel.h"
#include "core/locate/face_boxes.h"
#include "core/locate/near_search.h"
#include "core/locate/ray_search.h"
#include "core/locate/unit_box.h"
#include "core/mesh/mesh.h"

namespace geodesic {

class FaceHierarchy {
 public:
  virtual ~FaceHierarchy() = default;

  // Both leave off when they are told to stop. Any number of threads may ask at once.
  virtual void find_closest(NearSearch& search) const = 0;
  virtual void find_first_hit(RaySearch& search, Poll& poll) const = 0;

  // Memory held, without the mesh and the boxes.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
};

// By the boxes, in double precision. They must outlive it.
[[nodiscard]] std::unique_ptr<FaceHierarchy> box_hierarchy(const FaceBoxes& boxes);

// Embree's, where the engine was built with it (GEODESIC_USE_EMBREE), otherwise box_hierarchy. All
// but `cancel` must outlive it. Null when cancelled.
[[nodiscard]] std::unique_ptr<FaceHierarchy> quickest_hierarchy(const Mesh& mesh,
                                                                const UnitBox& unit,
                                                                const FaceBoxes& boxes,
                                                                const Cancel& cancel);

}  // namespace geodesic
