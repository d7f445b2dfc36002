#include "core/surface/roughness.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace geodesic {
namespace {

constexpr std::size_t kSampledEdges = 4096;
constexpr std::size_t kOneIn = 5;
constexpr double kCosine = 0.966;  // of 15 degrees

// Of the triangle that the two sides at the halfedge's tail span, in the halfedge's direction.
Vec3 normal_of(const FaceRecord& face, std::uint32_t c, std::span<const Vec3> positions) {
  const Vec3 tail = positions[face.vertex[c]];
  return cross(positions[face.vertex[next_corner(c)]] - tail,
               positions[face.vertex[previous_corner(c)]] - tail);
}

}  // namespace

bool is_rough(std::span<const FaceRecord> faces, std::span<const Vec3> positions) {
  const std::size_t step = 3 * faces.size() / kSampledEdges + 1;
  std::size_t bends = 0;
  std::size_t count = 0;
  for (std::size_t side = 0; side < 3 * faces.size(); side += step) {
    const auto h =
        halfedge(static_cast<std::uint32_t>(side / 3), static_cast<std::uint32_t>(side % 3));
    const FaceRecord& face = faces[face_of(h)];
    const Halfedge other = face.ring[corner_of(h)];
    const FaceRecord& across = faces[face_of(other)];
    if (other == h || across.ring[corner_of(other)] != h) continue;
    const Vec3 a = normal_of(face, corner_of(h), positions);
    const Vec3 b = normal_of(across, corner_of(other), positions);
    const double lengths = norm(a) * norm(b);
    if (!(lengths > 0)) continue;
    // Laid out flat, the faces lie on the two sides of the edge. Both go along it from the same
    // end only where their windings differ.
    const bool is_same_way = face.vertex[corner_of(h)] == across.vertex[corner_of(other)];
    ++count;
    if (!((is_same_way ? -dot(a, b) : dot(a, b)) > kCosine * lengths)) ++bends;
  }
  return kOneIn * bends > count;
}

}  // namespace geodesic
