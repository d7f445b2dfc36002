// The surface as exact propagation walks on it: edges, each with a frame of its own,
// without any windows yet, and faces as the edges on
// their sides. Built from the mesh's positions, so that an edge has one length whichever face
// asks, and kept for the next query on the same surface.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/exact/edge.h"
#include "core/surface/adjacency.h"

namespace geodesic::exact {

struct FaceFrame {
  std::array<std::uint32_t, 3> edge;  // side c, from vertex[c] to vertex[c + 1]
  // Bit c: side c goes from the edge's head to its tail; bit 3: a face before has the same edges;
  // bit 4: its corners lie on one line, as far as rounding can tell, or two in one place.
  std::uint32_t reversed;

  [[nodiscard]] bool is_copy() const { return (reversed & kCopy) != 0; }
  static constexpr std::uint32_t kCopy = 8;
  [[nodiscard]] bool is_flat() const { return (reversed & kFlat) != 0; }
  static constexpr std::uint32_t kFlat = 16;
  [[nodiscard]] bool is_reversed(std::uint32_t c) const { return ((reversed >> c) & 1U) != 0; }
};

struct CornerAngle {
  double cosine;
  double sine;
};

// What shortest paths do at a vertex.
enum class Bends : std::uint8_t {
  nowhere,     // the surface is flat or convex there
  beyond,      // into the angles more than pi away from the way they came: a saddle
               // vertex, or one on the boundary
  everywhere,  // faces do not form one fan, or are too thin to measure angles in
};

class Frames {
 public:
  // Both must outlive its use. Of no use if the poll says to stop.
  void build(const Adjacency& adjacency, const Triangulation& surface, Poll& poll);

  [[nodiscard]] std::span<Edge> edges() { return edges_; }
  [[nodiscard]] std::span<const Edge> edges() const { return edges_; }
  [[nodiscard]] const Edge& edge(std::uint32_t e) const { return edges_[e]; }
  [[nodiscard]] const FaceFrame& face(std::uint32_t f) const { return faces_[f]; }
  [[nodiscard]] std::uint32_t edge_of(Halfedge h) const {
    return faces_[face_of(h)].edge[corner_of(h)];
  }
  [[nodiscard]] bool is_reversed(Halfedge h) const {
    return faces_[face_of(h)].is_reversed(corner_of(h));
  }
  [[nodiscard]] double length(std::uint32_t f, std::uint32_t c) const {
    return edges_[faces_[f].edge[c]].length;
  }
  [[nodiscard]] CornerAngle angle(std::uint32_t f, std::uint32_t c) const {
    const FaceRecord& record = surface_.faces[f];
    // A line, exactly: a window along it would take for a height what rounding leaves of one, or
    // makes of sides of no length.
    if (faces_[f].is_flat()) [[unlikely]]
      return {c == previous_corner(record.longest_side()) ? -1.0 : 1.0, 0};
    const double product = length(f, c) * length(f, previous_corner(c));
    const double x = record.dot[c] / product;
    const double y = record.area2 / product;
    // Brought back to the unit circle, or unfolding would stretch.
    const double norm = std::sqrt(x * x + y * y);
    return {x / norm, y / norm};
  }
  // Whether there are flat faces.
  [[nodiscard]] bool has_flat() const { return has_flat_; }
  [[nodiscard]] std::span<const Bends> bends() const { return bends_; }
  // The mean over the faces of their shortest side.
  [[nodiscard]] double mean_shortest_side() const { return mean_shortest_side_; }

 private:
  void forget_arrivals(Poll& poll);
  void number_edges(const Adjacency& adjacency, Poll& poll);
  void mark_copies(Poll& poll);
  [[nodiscard]] std::vector<double> measure_faces(Poll& poll);
  void classify_vertices(const Adjacency& adjacency, std::span<const double> angle_sum, Poll& poll);

  Triangulation surface_;
  // Of the adjacency that they were built for; of none while they are built.
  std::weak_ptr<const void> built_for_;
  bool is_mesh_ = false;  // the surface is the mesh's own faces
  bool has_flat_ = false;
  std::vector<Edge> edges_;
  std::vector<FaceFrame> faces_;
  std::vector<Bends> bends_;
  double mean_shortest_side_ = 0;
};

}  // namespace geodesic::exact
