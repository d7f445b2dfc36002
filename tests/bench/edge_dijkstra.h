// The yardstick: Dijkstra's algorithm along the edges of the mesh, as in a textbook: lists of
// neighbours with the edges' lengths, and a heap of vertex numbers whose keys are looked up among
// the distances. What visits every vertex in the order of its distance can hardly cost less.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/field/vertex_distances.h"
#include "core/surface/adjacency.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {

// A heap of vertices, four below each, by the least distance.
class TextbookHeap {
 public:
  // Of vertices that have infinite distances, and none is in the heap.
  void reset(std::span<const double> distance) {
    distance_ = distance;
    place_.assign(distance.size(), kNowhere);
    heap_.clear();
  }
  [[nodiscard]] bool empty() const { return heap_.empty(); }
  // The distance of a vertex is less than it was.
  void push_or_lower(std::uint32_t vertex) {
    std::size_t i = place_[vertex];
    if (i == kNowhere) {
      i = heap_.size();
      heap_.push_back(vertex);
    }
    const double key = distance_[vertex];
    while (i > 0) {
      const std::size_t parent = (i - 1) / 4;
      if (distance_[heap_[parent]] <= key) break;
      put(i, heap_[parent]);
      i = parent;
    }
    put(i, vertex);
  }
  std::uint32_t pop() {
    const std::uint32_t top = heap_.front();
    const std::uint32_t last = heap_.back();
    heap_.pop_back();
    const std::size_t size = heap_.size();
    if (size == 0) return top;
    const double key = distance_[last];
    std::size_t i = 0;
    for (std::size_t first = 1; first < size; first = 4 * i + 1) {
      std::size_t least = first;
      double least_key = distance_[heap_[first]];
      const std::size_t end = std::min(first + 4, size);
      for (std::size_t child = first + 1; child < end; ++child) {
        const double child_key = distance_[heap_[child]];
        if (child_key < least_key) {
          least = child;
          least_key = child_key;
        }
      }
      if (least_key >= key) break;
      put(i, heap_[least]);
      i = least;
    }
    put(i, last);
    return top;
  }

 private:
  static constexpr std::uint32_t kNowhere = 0xffffffffU;
  void put(std::size_t i, std::uint32_t vertex) {
    heap_[i] = vertex;
    place_[vertex] = static_cast<std::uint32_t>(i);
  }

  std::span<const double> distance_;
  std::vector<std::uint32_t> heap_;
  std::vector<std::uint32_t> place_;  // of each vertex in heap_; once popped, of no use
};

class EdgeDijkstra {
 public:
  // `numbers`: what each of the mesh's vertices is called here. Empty: as in the mesh.
  explicit EdgeDijkstra(const Adjacency& adjacency, std::span<const std::uint32_t> numbers = {})
      : numbers_(numbers.begin(), numbers.end()) {
    const std::uint32_t vertex_count = adjacency.mesh().vertex_count();
    if (numbers_.empty()) {
      numbers_.resize(vertex_count);
      std::iota(numbers_.begin(), numbers_.end(), 0U);
    }
    std::vector<std::uint32_t> called(vertex_count);
    for (std::uint32_t v = 0; v < vertex_count; ++v) called[numbers_[v]] = v;
    const auto positions = adjacency.mesh().positions();
    std::vector<std::uint32_t> around;
    begin_.push_back(0);
    for (const std::uint32_t v : called) {
      around.clear();
      for (const std::uint32_t corner : adjacency.corners(v)) {
        const FaceRecord& face = adjacency.face(face_of(corner));
        around.push_back(face.vertex[next_corner(corner_of(corner))]);
        around.push_back(face.vertex[previous_corner(corner_of(corner))]);
      }
      // An inner edge is in two faces, and a neighbour once in the list.
      std::sort(around.begin(), around.end());
      around.erase(std::unique(around.begin(), around.end()), around.end());
      for (const std::uint32_t w : around) {
        neighbours_.push_back({numbers_[w], geodesic::distance(positions[v], positions[w])});
      }
      begin_.push_back(static_cast<std::uint32_t>(neighbours_.size()));
    }
  }

  // From one of the mesh's vertices: along edges, so never below the geodesic's.
  void run(std::uint32_t source) {
    distance_.assign(begin_.size() - 1, kUnreached);
    heap_.reset(distance_);
    distance_[numbers_[source]] = 0;
    heap_.push_or_lower(numbers_[source]);
    while (!heap_.empty()) {
      const std::uint32_t v = heap_.pop();
      const double here = distance_[v];
      for (std::uint32_t i = begin_[v]; i < begin_[v + 1]; ++i) {
        const Neighbour& to = neighbours_[i];
        const double d = here + to.length;
        if (!(d < distance_[to.vertex])) continue;
        distance_[to.vertex] = d;
        heap_.push_or_lower(to.vertex);
      }
    }
  }
  // Of one of the mesh's vertices.
  [[nodiscard]] double distance(std::uint32_t vertex) const { return distance_[numbers_[vertex]]; }

 private:
  struct Neighbour {
    std::uint32_t vertex;
    double length;
  };

  std::vector<std::uint32_t> numbers_;
  std::vector<std::uint32_t> begin_;  // vertex_count + 1
  std::vector<Neighbour> neighbours_;
  TextbookHeap heap_;
  std::vector<double> distance_;
};

// The quicker of two: over the vertices in the order of the file, and in the order of the mesh.
class Yardstick {
 public:
  explicit Yardstick(const Adjacency& adjacency)
      : in_our_order_(adjacency), in_file_order_(adjacency, file_order(adjacency.mesh())) {}

  // Milliseconds of processor time, from a vertex.
  [[nodiscard]] double ms(std::uint32_t source) {
    const double ours = processor_ms_of([&] { in_our_order_.run(source); });
    const double theirs = processor_ms_of([&] { in_file_order_.run(source); });
    return std::min(ours, theirs);
  }
  [[nodiscard]] EdgeDijkstra& in_our_order() { return in_our_order_; }
  [[nodiscard]] EdgeDijkstra& in_file_order() { return in_file_order_; }

 private:
  // The rank of each vertex among the first of the file's that it is made of.
  static std::vector<std::uint32_t> file_order(const Mesh& mesh) {
    std::vector<std::uint32_t> by_file(mesh.vertex_count());
    std::iota(by_file.begin(), by_file.end(), 0U);
    std::sort(by_file.begin(), by_file.end(), [&](std::uint32_t a, std::uint32_t b) {
      return mesh.source_of_vertex(a) < mesh.source_of_vertex(b);
    });
    std::vector<std::uint32_t> numbers(by_file.size());
    for (std::uint32_t i = 0; i < by_file.size(); ++i) numbers[by_file[i]] = i;
    return numbers;
  }

  EdgeDijkstra in_our_order_;
  EdgeDijkstra in_file_order_;
};

}  // namespace geodesic::bench
