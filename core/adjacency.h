// The prepared adjacency of a mesh: what every method walks on, built once per
// mesh and then shared and never changed.
//
// Halfedges and corners share one numbering, 4 * face + c with c in 0, 1, 2:
//   corner   4f + c: the corner of face f at vertex[c];
//   halfedge 4f + c: the edge of face f from vertex[c] to vertex[c + 1], with
//                    vertex[c + 2] opposite it.
//
// Geometry is intrinsic: a face is unfolded into a plane by three corner dot
// products and twice its area, from which the unfolded apex over any of its
// three edges follows without a square root (see virtual_source.h). One face is
// one cache line.
//
// Winding plays no part. The halfedges on the same undirected edge form a ring
// (`ring`): a boundary edge's halfedge is alone in it, an inner edge has two, a
// non-manifold edge any number. All faces at a vertex are listed whether or not
// they form one fan. So distances pass flipped faces, the pages of a book and
// bowtie vertices as the surface does.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/cancel.h"
#include "core/error.h"
#include "core/mesh.h"
#include "core/virtual_source.h"

namespace geodesic {

using Halfedge = std::uint32_t;

[[nodiscard]] constexpr std::uint32_t face_of(Halfedge h) { return h >> 2U; }
[[nodiscard]] constexpr std::uint32_t corner_of(Halfedge h) { return h & 3U; }
[[nodiscard]] constexpr Halfedge halfedge(std::uint32_t face, std::uint32_t corner) {
  return 4 * face + corner;
}
[[nodiscard]] constexpr std::uint32_t next_corner(std::uint32_t c) { return c == 2 ? 0 : c + 1; }
[[nodiscard]] constexpr std::uint32_t previous_corner(std::uint32_t c) {
  return c == 0 ? 2 : c - 1;
}

struct alignas(64) FaceRecord {
  std::array<std::uint32_t, 3> vertex;
  std::array<Halfedge, 3> ring;  // the next halfedge on the same edge, cyclic
  std::array<double, 3> dot;     // at each corner, the dot product of the two edges leaving it
  double area2;                  // twice the area

  // Squared length of the edge vertex[c] - vertex[c + 1].
  [[nodiscard]] double length2(std::uint32_t c) const { return dot[c] + dot[next_corner(c)]; }
  // The corner that the longest edge begins at, so that the edge is c - next_corner(c).
  [[nodiscard]] std::uint32_t longest_side() const {
    const std::uint32_t c = length2(1) > length2(0) ? 1 : 0;
    return length2(2) > length2(c) ? 2 : c;
  }
  // The vertex opposite the base vertex[c] -> vertex[c + 1], unfolded over it.
  [[nodiscard]] UnfoldedApex apex_over(std::uint32_t c) const {
    const double p = dot[c];
    const double q = dot[next_corner(c)];
    const double w = dot[previous_corner(c)];
    return {p, q, area2, p + w, q + w};
  }
};

struct TopologyReport {
  std::uint64_t edges = 0;
  std::uint64_t edges_boundary = 0;      // in one face
  std::uint64_t edges_non_manifold = 0;  // in three faces or more
  std::uint64_t boundary_loops = 0;
  std::uint64_t components = 0;         // of faces, joined through vertices
  std::uint64_t vertices_isolated = 0;  // in no face
  std::uint64_t vertices_pinched = 0;   // where faces meet in nothing but the vertex
  std::uint64_t faces_duplicate = 0;    // with the same three vertices as an earlier one
  double mean_edge = 0;                 // mean length over all edges, mesh units
};

class Adjacency {
 public:
  [[nodiscard]] static Adjacency build(std::shared_ptr<const Mesh> mesh);
  // Errors: cancelled.
  [[nodiscard]] static Result<Adjacency> build(std::shared_ptr<const Mesh> mesh,
                                               const Cancel& cancel);

  [[nodiscard]] const Mesh& mesh() const { return *mesh_; }
  [[nodiscard]] std::span<const FaceRecord> faces() const { return faces_; }
  [[nodiscard]] const FaceRecord& face(std::uint32_t f) const { return faces_[f]; }

  // The corners at a vertex, in ascending order.
  [[nodiscard]] std::span<const std::uint32_t> corners(std::uint32_t vertex) const {
    return {corners_.data() + corner_begin_[vertex],
            corner_begin_[vertex + 1] - corner_begin_[vertex]};
  }
  // The next halfedge on the same edge; itself on a boundary.
  [[nodiscard]] Halfedge ring(Halfedge h) const { return faces_[face_of(h)].ring[corner_of(h)]; }

  // Whether the faces at a vertex fall into parts that share no edge there, as in
  // a bowtie.
  [[nodiscard]] bool is_pinched(std::uint32_t vertex) const {
    return !pinched_.empty() && pinched_[vertex];
  }

  // A face that has both vertices, as the halfedge between them (in either
  // direction), or kNone.
  [[nodiscard]] Halfedge find_edge(std::uint32_t a, std::uint32_t b) const;

  [[nodiscard]] const TopologyReport& report() const { return report_; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  // Each of these leaves off when the poll says to stop.
  void fill_geometry(Poll& poll);
  void fill_corners(Poll& poll);
  void fill_rings(Poll& poll);
  void find_pinched_vertices(Poll& poll);
  [[nodiscard]] std::size_t faces_in_first_fan(std::uint32_t vertex) const;
  void count_components(Poll& poll);
  void count_boundary_loops(Poll& poll);

  std::shared_ptr<const Mesh> mesh_;
  std::vector<FaceRecord> faces_;
  std::vector<std::uint32_t> corner_begin_;  // vertex_count + 1
  std::vector<std::uint32_t> corners_;
  std::vector<bool> pinched_;  // per vertex; empty when no vertex is
  TopologyReport report_;
};

}  // namespace geodesic
