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
#include <utility>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/shared_array.h"
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
class RefinedSurface;     // refined_surface.h

class Adjacency {
 public:
  [[nodiscard]] static Adjacency build(std::shared_ptr<const Mesh> mesh);
  // Errors: cancelled.
  [[nodiscard]] static Result<Adjacency> build(std::shared_ptr<const Mesh> mesh,
                                               const Cancel& cancel);

  // All that it consists of, besides the mesh. Written to a file and read back, it is the same.
  struct Parts {
    SharedArray<FaceRecord> faces;
    SharedArray<std::uint32_t> corner_begin;  // vertex_count + 1
    SharedArray<std::uint32_t> corners;
    SharedArray<std::uint64_t> pinched;  // a bit a vertex; empty when no vertex is
    bool is_oriented = true;
    bool is_even = false;
    bool has_flat_faces = false;
    bool has_lines = false;
    bool is_crowded = false;
    bool is_rough = false;                              // roughness.h
    bool has_large_faces = false;                       // see the member function
    double longest2 = 0;                                // as in Triangulation
    std::shared_ptr<const IntrinsicDelaunay> delaunay;  // null when no edge was flipped
    std::shared_ptr<const RefinedSurface> refined;      // null where it would be no better
    TopologyReport report;
  };
  // `parts` are those of what `build` has made of this mesh; they are not checked.
  Adjacency(std::shared_ptr<const Mesh> mesh, Parts parts);
  [[nodiscard]] const Parts& parts() const { return parts_; }

  [[nodiscard]] const Mesh& mesh() const { return *mesh_; }
  // Known again by its owner (std::weak_ptr::owner_before), for who keeps what follows from
  // these arrays: copies share it, and nothing that is built later has it, though it may
  // come to lie at the same address.
  [[nodiscard]] std::weak_ptr<const void> identity() const { return identity_; }
  [[nodiscard]] std::span<const FaceRecord> faces() const { return parts_.faces; }
  [[nodiscard]] const FaceRecord& face(std::uint32_t f) const { return parts_.faces[f]; }

  // The corners at a vertex, in ascending order.
  [[nodiscard]] std::span<const std::uint32_t> corners(std::uint32_t vertex) const {
    return {parts_.corners.data() + parts_.corner_begin[vertex],
            parts_.corner_begin[vertex + 1] - parts_.corner_begin[vertex]};
  }
  // The next halfedge on the same edge; itself on a boundary.
  [[nodiscard]] Halfedge ring(Halfedge h) const {
    return parts_.faces[face_of(h)].ring[corner_of(h)];
  }

  // The vertices that a halfedge leads from and to, and the one opposite it.
  [[nodiscard]] std::uint32_t tail(Halfedge h) const {
    return face(face_of(h)).vertex[corner_of(h)];
  }
  [[nodiscard]] std::uint32_t head(Halfedge h) const {
    return face(face_of(h)).vertex[next_corner(corner_of(h))];
  }
  [[nodiscard]] std::uint32_t apex(Halfedge h) const {
    return face(face_of(h)).vertex[previous_corner(corner_of(h))];
  }

  // The faces of the mesh, and those that cut the same surface up best for what is
  // computed from triangle to triangle: the same where nothing was to be improved.
  [[nodiscard]] Triangulation triangulation() const;
  [[nodiscard]] Triangulation delaunay() const;
  // One with more vertices, for windows on meshes of needles; or null.
  [[nodiscard]] const RefinedSurface* refined() const { return parts_.refined.get(); }

  // Whether the surface bends much from face to face (roughness.h).
  [[nodiscard]] bool is_rough() const { return parts_.is_rough; }
  // Whether more than a twentieth of the area is in faces longer than a fifth of the mesh's box,
  // as the flat sides of machine parts are.
  [[nodiscard]] bool has_large_faces() const { return parts_.has_large_faces; }

  // Whether the faces at a vertex fall into parts that share no edge there, as in
  // a bowtie.
  [[nodiscard]] bool is_pinched(std::uint32_t vertex) const {
    return !parts_.pinched.empty() && (parts_.pinched[vertex / 64] >> (vertex % 64) & 1U) != 0;
  }

  // A face that has both vertices, as the halfedge between them (in either
  // direction), or kNone.
  [[nodiscard]] Halfedge find_edge(std::uint32_t a, std::uint32_t b) const;

  [[nodiscard]] const TopologyReport& report() const { return parts_.report; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const void> identity_;
  Parts parts_;
};

}  // namespace geodesic
