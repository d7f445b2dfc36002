// The prepared adjacency of a mesh: what every method walks on, built once per
// mesh and then shared and never changed.
//
// Geometry is intrinsic: a face is unfolded into a plane by three corner dot
// products and twice its area (face_record.h), from which the unfolded apex over any
// of its three edges follows without a square root (see unfolded_apex.h).
//
// Winding plays no part. The halfedges on the same undirected edge form a ring
// (`ring`): a boundary edge's halfedge is alone in it, an inner edge has two, a
// non-manifold edge any number. All faces at a vertex are listed whether or not
// they form one fan. So distances pass flipped faces, the pages of a book and
// bowtie vertices as the surface does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "core/surface/face_record.h"
#include "core/surface/triangulation.h"

namespace geodesic {

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

class IntrinsicDelaunay;  // intrinsic_delaunay.h

class Adjacency {
 public:
  [[nodiscard]] static Adjacency build(std::shared_ptr<const Mesh> mesh);
  // Errors: cancelled.
  [[nodiscard]] static Result<Adjacency> build(std::shared_ptr<const Mesh> mesh,
                                               const Cancel& cancel);

  [[nodiscard]] const Mesh& mesh() const { return *mesh_; }
  // Known again by its owner (std::weak_ptr::owner_before), for who keeps what follows from
  // these arrays: copies share it, and nothing that is built later has it, though it may
  // come to lie at the same address.
  [[nodiscard]] std::weak_ptr<const void> identity() const { return identity_; }
  [[nodiscard]] std::span<const FaceRecord> faces() const { return faces_; }
  [[nodiscard]] const FaceRecord& face(std::uint32_t f) const { return faces_[f]; }

  // The corners at a vertex, in ascending order.
  [[nodiscard]] std::span<const std::uint32_t> corners(std::uint32_t vertex) const {
    return {corners_.data() + corner_begin_[vertex],
            corner_begin_[vertex + 1] - corner_begin_[vertex]};
  }
  // The next halfedge on the same edge; itself on a boundary.
  [[nodiscard]] Halfedge ring(Halfedge h) const { return faces_[face_of(h)].ring[corner_of(h)]; }

  // The faces of the mesh, and those that cut the same surface up best for what is
  // computed from triangle to triangle: the same where nothing was to be improved.
  [[nodiscard]] Triangulation triangulation() const {
    return {faces_,   corner_begin_,   corners_,    is_oriented_,
            is_even_, has_flat_faces_, is_crowded_, has_lines_};
  }
  [[nodiscard]] Triangulation delaunay() const;

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
  [[nodiscard]] std::size_t faces_in_first_fan(std::uint32_t vertex, Poll& poll) const;
  void count_components(Poll& poll);
  void count_boundary_loops(Poll& poll);

  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const void> identity_;
  std::vector<FaceRecord> faces_;
  std::vector<std::uint32_t> corner_begin_;  // vertex_count + 1
  std::vector<std::uint32_t> corners_;
  bool is_oriented_ = true;
  bool is_even_ = false;
  bool has_flat_faces_ = false;
  bool has_lines_ = false;
  bool is_crowded_ = false;
  std::vector<bool> pinched_;                          // per vertex; empty when no vertex is
  std::shared_ptr<const IntrinsicDelaunay> delaunay_;  // null when no edge was flipped
  TopologyReport report_;
};

}  // namespace geodesic
