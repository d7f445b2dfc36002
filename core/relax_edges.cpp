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

}  // namespace

void relax_edges(const Adjacency& adjacency, double max, bool reaches_more, Field& field,
                 Poll& poll) {
  const std::span<double> distance = field.distance;
  // By positions: all the faces' records would be twice as much to read.
  const std::span<const Vec3> positions = adjacency.mesh().positions();
  std::vector<std::uint32_t> lowered;
  const auto is_above = [&](std::uint32_t u, std::uint32_t v) -> unsigned {
    const Vec3 edge = positions[v] - positions[u];
    const double difference = distance[v] - distance[u];  // not a number between unreached ones
    return difference * difference > (1 + kRounding) * dot(edge, edge) ? 1 : 0;
  };
  const auto relax = [&](std::uint32_t u, std::uint32_t v) {
    if (is_above(u, v) == 0) return;
    if (distance[u] > distance[v]) std::swap(u, v);
    const double along = distance[u] + geodesic::distance(positions[u], positions[v]);
    if (!(along < distance[v]) || along > max) return;
    if (distance[v] == kUnreached && !reaches_more) return;
    distance[v] = along;
    if (!field.nearest_source.empty()) field.nearest_source[v] = field.nearest_source[u];
    lowered.push_back(v);
  };
  const std::span<const Triangle> faces = adjacency.mesh().faces();
  for (const Triangle& face : faces) {
    if (poll.cancelled()) return;
    const auto [a, b, c] = face;
    // Without a branch each.
    if ((is_above(a, b) | is_above(b, c) | is_above(c, a)) == 0) [[likely]]
      continue;
    relax(a, b);
    relax(b, c);
    relax(c, a);
  }
  while (!lowered.empty() && !poll.cancelled()) {
    const std::uint32_t v = lowered.back();
    lowered.pop_back();
    for (const std::uint32_t corner : adjacency.corners(v)) {
      const FaceRecord& face = adjacency.face(face_of(corner));
      const std::uint32_t c = corner_of(corner);
      relax(v, face.vertex[next_corner(c)]);
      relax(v, face.vertex[previous_corner(c)]);
    }
  }
}

}  // namespace geodesic
