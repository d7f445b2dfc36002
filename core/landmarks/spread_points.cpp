#include "core/landmarks/spread_points.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>

#include "core/base/vec3.h"
#include "core/field/field.h"

namespace geodesic {
namespace {

std::uint32_t heaviest_corner(const Adjacency& adjacency, const SurfacePoint& point) {
  if (point.at_vertex()) return point.vertex;
  const auto most = std::max_element(point.bary.begin(), point.bary.end());
  return adjacency.mesh().faces()[point.face][static_cast<std::size_t>(most - point.bary.begin())];
}

// Dijkstra's distances from a set of vertices that grows. The search from a new one ends where
// an older one is nearer.
class GrowingSet {
 public:
  explicit GrowingSet(const Adjacency& adjacency)
      : adjacency_(adjacency), distance_(adjacency.mesh().vertex_count(), kUnreached) {}

  [[nodiscard]] double distance(std::uint32_t vertex) const { return distance_[vertex]; }

  void add(std::uint32_t vertex, Poll& poll) {
    waiting_.clear();
    lower(vertex, 0);
    while (!waiting_.empty() && !poll.cancelled()) {
      std::pop_heap(waiting_.begin(), waiting_.end(), std::greater());
      const auto [distance, v] = waiting_.back();
      waiting_.pop_back();
      if (distance > distance_[v]) continue;  // lowered once more since
      for (const std::uint32_t corner : adjacency_.corners(v)) {
        const FaceRecord& face = adjacency_.face(face_of(corner));
        const std::uint32_t c = corner_of(corner);
        for (const std::uint32_t w :
             {face.vertex[next_corner(c)], face.vertex[previous_corner(c)]}) {
          lower(w, distance + length(v, w));
        }
      }
    }
  }

 private:
  [[nodiscard]] double length(std::uint32_t v, std::uint32_t w) const {
    const auto positions = adjacency_.mesh().positions();
    return geodesic::distance(positions[v], positions[w]);
  }
  void lower(std::uint32_t v, double distance) {
    if (!(distance < distance_[v])) return;
    distance_[v] = distance;
    waiting_.push_back({distance, v});
    std::push_heap(waiting_.begin(), waiting_.end(), std::greater());
  }

  const Adjacency& adjacency_;
  std::vector<double> distance_;
  std::vector<std::pair<double, std::uint32_t>> waiting_;  // a heap
};

}  // namespace

Result<std::vector<std::uint32_t>> spread_points(const Adjacency& adjacency,
                                                 std::span<const SurfacePoint> points,
                                                 std::size_t count, const Cancel& cancel) {
  Poll poll(cancel);
  std::vector<std::uint32_t> vertices;
  for (const SurfacePoint& point : points) {
    if (poll.cancelled()) break;
    vertices.push_back(heaviest_corner(adjacency, point));
  }
  GrowingSet spread(adjacency);
  std::vector<std::uint32_t> chosen;
  while (chosen.size() < std::min(count, points.size()) && !poll.stopped()) {
    std::uint32_t farthest = 0;
    for (std::uint32_t i = 1; i < vertices.size() && !poll.cancelled(); ++i) {
      if (spread.distance(vertices[i]) > spread.distance(vertices[farthest])) farthest = i;
    }
    if (spread.distance(vertices[farthest]) == 0) break;
    chosen.push_back(farthest);
    spread.add(vertices[farthest], poll);
  }
  if (poll.stopped()) return fail_stopped(poll);
  return chosen;
}

}  // namespace geodesic
