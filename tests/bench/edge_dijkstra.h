// The yardstick: Dijkstra's algorithm along the edges of the mesh, as in a
// textbook, over lists of neighbours with the edges' lengths. What visits every
// vertex in the order of its distance can hardly cost less.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/field/field.h"
#include "core/field/vertex_heap.h"
#include "core/surface/adjacency.h"

namespace geodesic::bench {

class EdgeDijkstra {
 public:
  explicit EdgeDijkstra(const Adjacency& adjacency) {
    const std::uint32_t vertex_count = adjacency.mesh().vertex_count();
    begin_.push_back(0);
    std::vector<Neighbour> around;
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
      around.clear();
      for (const std::uint32_t corner : adjacency.corners(v)) {
        const FaceRecord& face = adjacency.face(face_of(corner));
        const std::uint32_t c = corner_of(corner);
        const std::uint32_t behind = previous_corner(c);
        around.push_back({face.vertex[next_corner(c)], length(face, c)});
        around.push_back({face.vertex[behind], length(face, behind)});
      }
      // An inner edge is in two faces, and a neighbour once in the list.
      std::sort(around.begin(), around.end(),
                [](const Neighbour& a, const Neighbour& b) { return a.vertex < b.vertex; });
      const auto end = std::unique(around.begin(), around.end(), [](const auto& a, const auto& b) {
        return a.vertex == b.vertex;
      });
      neighbours_.insert(neighbours_.end(), around.begin(), end);
      begin_.push_back(static_cast<std::uint32_t>(neighbours_.size()));
    }
  }

  // Fills distance() from one vertex: along edges, so never below the geodesic's.
  void run(std::uint32_t source) {
    const std::size_t vertex_count = begin_.size() - 1;
    distance_.assign(vertex_count, kUnreached);
    heap_.reset(vertex_count);
    distance_[source] = 0;
    heap_.push_or_lower(source, 0);
    while (!heap_.empty()) {
      const VertexHeap::Entry next = heap_.pop();
      for (std::uint32_t i = begin_[next.vertex]; i < begin_[next.vertex + 1]; ++i) {
        const Neighbour& to = neighbours_[i];
        const double d = next.key + to.length;
        if (!(d < distance_[to.vertex])) continue;
        distance_[to.vertex] = d;
        heap_.push_or_lower(to.vertex, d);
      }
    }
  }
  [[nodiscard]] std::span<const double> distance() const { return distance_; }

 private:
  struct Neighbour {
    std::uint32_t vertex;
    double length;
  };
  static double length(const FaceRecord& face, std::uint32_t side) {
    return std::sqrt(std::max(face.length2(side), 0.0));
  }

  std::vector<std::uint32_t> begin_;  // vertex_count + 1
  std::vector<Neighbour> neighbours_;
  VertexHeap heap_;
  std::vector<double> distance_;
};

}  // namespace geodesic::bench
