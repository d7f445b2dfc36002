// The face of a mesh that is closest to a point, of those it is shown one after the other. Which to
// show is for a hierarchy to say (face_hierarchy.h); the arithmetic is here, in double precision.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/cancel.h"
#include "core/locate/closest_on_triangle.h"
#include "core/locate/unit_box.h"
#include "core/mesh/mesh.h"

namespace geodesic {

class NearSearch {
 public:
  // `mesh` must outlive it.
  NearSearch(const Mesh& mesh, const UnitBox& unit, Vec3 from, const Cancel& cancel)
      : mesh_(mesh), from_(from), q_(unit.inside(from)), scale_(unit.scale), poll_(cancel) {}

  // The point in the frame of the UnitBox.
  [[nodiscard]] Vec3 q() const { return q_; }

  // True when the face is closer than all before it. Of faces at the same distance the one of the
  // lowest number is kept, whatever the order in which they are shown.
  bool consider(std::uint32_t face);

  // How far from q() faces can be, in the frame, that are still to be shown; `margin`: by how much
  // whoever shows them may misplace them.
  [[nodiscard]] double radius(double margin) const {
    return std::sqrt(best2_) * scale_ * 1.00001 + margin;
  }

  [[nodiscard]] bool is_cancelled() { return poll_.cancelled(); }
  [[nodiscard]] bool was_cancelled() const { return poll_.stopped(); }

  [[nodiscard]] std::uint32_t face() const { return face_; }
  [[nodiscard]] const TriangleWeights& bary() const { return bary_; }

 private:
  const Mesh& mesh_;
  Vec3 from_;
  Vec3 q_;
  double scale_;
  Poll poll_;
  double best2_ = std::numeric_limits<double>::infinity();  // mesh units
  std::uint32_t face_ = kNone;
  TriangleWeights bary_{};
};

}  // namespace geodesic
