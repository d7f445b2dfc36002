#include "core/locate/face_boxes.h"

#include <utility>

namespace geodesic {
namespace {

void grow(Box& box, const Box& other) {
  box.min = {std::min(box.min.x, other.min.x), std::min(box.min.y, other.min.y),
             std::min(box.min.z, other.min.z)};
  box.max = {std::max(box.max.x, other.max.x), std::max(box.max.y, other.max.y),
             std::max(box.max.z, other.max.z)};
}

constexpr Box kEmpty{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

}  // namespace

FaceBoxes::FaceBoxes(const Mesh& mesh, const UnitBox& unit, Poll& poll)
    : face_count_(mesh.face_count()) {
  std::vector<Box> boxes((mesh.face_count() + kFacesOfBox - 1) / kFacesOfBox, kEmpty);
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    if (poll.cancelled()) break;
    for (const std::uint32_t v : mesh.faces()[f]) {
      const Vec3 corner = unit.inside(mesh.positions()[v]);
      grow(boxes[f / kFacesOfBox], {corner, corner});
    }
  }
  levels_.push_back(std::move(boxes));
  while (levels_.back().size() > 1) {
    const std::vector<Box>& below = levels_.back();
    std::vector<Box> above((below.size() + kBoxesOfBox - 1) / kBoxesOfBox, kEmpty);
    for (std::size_t i = 0; i < below.size(); ++i) grow(above[i / kBoxesOfBox], below[i]);
    levels_.push_back(std::move(above));
  }
}

std::size_t FaceBoxes::bytes() const {
  std::size_t bytes = sizeof(*this);
  for (const std::vector<Box>& level : levels_) bytes += level.capacity() * sizeof(Box);
  return bytes;
}

}  // namespace geodesic
