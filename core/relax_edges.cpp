#include "core/relax_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace geodesic {
namespace {

// What is above by less than this part of an edge's length is above by rounding.
constexpr double kRounding = 1e-12;

}  // namespace

void relax_edges(const Adjacency& adjacency, double max, bool reaches_more, Field& field,
                 Poll& poll) {
  std::vector<double>& distance = field.distance;
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
  for (const FaceRecord& face : adjacency.faces()) {
    if (poll.cancelled()) return;
    for (std::uint32_t c = 0; c < 3; ++c) {
      relax(face.vertex[c], face.vertex[next_corner(c)], face.length2(c));
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
