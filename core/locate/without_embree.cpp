// In place of embree_hierarchy.cpp where the engine is built without Embree.
#include "core/locate/face_hierarchy.h"

namespace geodesic {

std::unique_ptr<FaceHierarchy> quickest_hierarchy(const Mesh& /*mesh*/, const UnitBox& /*unit*/,
                                                  const FaceBoxes& boxes,
                                                  const Cancel& /*cancel*/) {
  return box_hierarchy(boxes);
}

}  // namespace geodesic
