#include "core/paths/down_edges.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <unordered_map>
#include <utility>

#include "core/paths/step_in_face.h"

namespace geodesic {

// Dijkstra 1959, over no more than the vertices it needs.
std::vector<StepBack> down_edges(const Adjacency& adjacency, const Field& field,
                                 std::uint32_t vertex, double below, Poll& poll) {
  struct Reached {
    double along = kUnreached;
    Halfedge by = kNone;  // the edge it was reached by, as a corner or the one before
    std::uint32_t from = kNone;
  };
  using Entry = std::pair<double, std::uint32_t>;
  std::unordered_map<std::uint32_t, Reached> reached;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  reached[vertex].along = 0;
  queue.push({0, vertex});
  // Each side of each face is gone along once from either end: a vertex is done with when
  // it comes out of the queue, and what is pushed is shorter than what was known.
  while (!queue.empty()) {
    const auto [along, v] = queue.top();
    queue.pop();
    if (along > reached[v].along) continue;
    if (field.distance[v] < below) {
      std::vector<StepBack> steps;
      for (std::uint32_t w = v; w != vertex; w = reached[w].from) {
        const Halfedge h = reached[w].by;
        const FaceRecord& face = adjacency.face(face_of(h));
        const std::uint32_t at =
            face.vertex[corner_of(h)] == w ? corner_of(h) : next_corner(corner_of(h));
        const std::uint32_t start = at == corner_of(h) ? next_corner(at) : corner_of(h);
        StepBack step;
        step.to = StepBack::To::vertex;
        step.distance = field.distance[w];
        step.face = face_of(h);
        step.start[start] = 1;
        step.bary[at] = 1;
        step.vertex = w;
        steps.push_back(step);
      }
      std::reverse(steps.begin(), steps.end());
      return steps;
    }
    for (const std::uint32_t corner : adjacency.corners(v)) {
      if (poll.cancelled()) return {};
      const FaceRecord& face = adjacency.face(face_of(corner));
      const std::uint32_t c = corner_of(corner);
      for (const std::uint32_t side : {c, previous_corner(c)}) {
        const std::uint32_t w = face.vertex[side == c ? next_corner(c) : side];
        const double length = along + std::sqrt(side_length2(adjacency, face_of(corner), side));
        Reached& there = reached[w];
        if (!(length < there.along)) continue;
        there = {length, halfedge(face_of(corner), side), v};
        queue.push({length, w});
      }
    }
  }
  return {};
}

}  // namespace geodesic
