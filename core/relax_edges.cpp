#include "core/relax_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace geodesic {
namespace {

// What is above by less than this part of an edge's length is above by rounding.
constexpr double kRounding = 1e-12;
// Of squared lengths by positions, which differ from those by corners in their last bits;
// on a thin face, in more of them.
constexpr double kNearly = 1 - 1e-6;

}  // namespace

void relax_edges(const Adjacency& adjacency, double max, bool reaches_more, Field& field,
                 Poll& poll) {
  std::vector<double>& distance = field.distance.doubles();
  std::vector<std::uint32_t> lowered;
  const auto relax = [&](std::uint32_t u, std::uint32_t v, double length2) {
    if (distance[u] > distance[v]) std::swap(u, v);
    const double difference = distance[v] - distance[u];  // not a number between unreached ones
    if (!(difference * difference > length2 * (1 + kRounding))) return;
    const double along = distance[u] + std::sqrt(std::max(length2, 0.0));
    if (!(along < distance[v]) || along > max) return;
    if (distance[v] == kUnreached && !reaches_more) return;
    distance[v] = along;
    if (!field.nearest_source.empty()) field.nearest_source[v] = field.nearest_source[u];
    lowered.push_back(v);
  };
  // Positions are half of what the faces' records are to read, and tell nearly always that
  // there is nothing to be done.
  const std::span<const Vec3> positions = adjacency.mesh().positions();
  const auto may_be_above = [&](std::uint32_t u, std::uint32_t v) -> unsigned {
    const Vec3 edge = positions[v] - positions[u];
    const double difference = distance[v] - distance[u];
    return difference * difference > kNearly * dot(edge, edge) ? 1 : 0;
  };
  const std::span<const Triangle> faces = adjacency.mesh().faces();
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    if (poll.cancelled()) return;
    const auto [a, b, c] = faces[f];
    if (!(std::min({distance[a], distance[b], distance[c]}) < kUnreached)) continue;
    // Without a branch each.
    if ((may_be_above(a, b) | may_be_above(b, c) | may_be_above(c, a)) == 0) continue;
    const FaceRecord& face = adjacency.face(f);
    for (std::uint32_t i = 0; i < 3; ++i) {
      relax(face.vertex[i], face.vertex[next_corner(i)], face.length2(i));
    }
  }
  while (!lowered.empty() && !poll.cancelled()) {
    const std::uint32_t v = lowered.back();
    lowered.pop_back();
    for (const std::uint32_t corner : adjacency.corners(v)) {
      const FaceRecord& face = adjacency.face(face_of(corner));
      const std::uint32_t c = corner_of(corner);
      const std::uint32_t behind = previous_corner(c);
      relax(v, face.vertex[next_corner(c)], face.length2(c));
      relax(v, face.vertex[behind], face.length2(behind));
    }
  }
}

}  // namespace geodesic
