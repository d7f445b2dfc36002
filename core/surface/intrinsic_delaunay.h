// The intrinsic Delaunay triangulation of a surface: the same vertices and the same
// distances over the surface, cut into other triangles, whose edges run straight over
// the faces of the mesh. Bobenko and Springborn, "A discrete Laplace-Beltrami operator
// for simplicial surfaces", Discrete and Computational Geometry 38, 2007, section 2;
// Fisher, Springborn, Bobenko, Schroeder, "An algorithm for the construction of
// intrinsic Delaunay triangulations", 2006: flip edges until each one's two opposite
// angles add up to at most pi. No triangulation of these vertices has larger least
// angles, so what is computed from triangle to triangle errs least on this one.
//
// Faces are numbered and glued as those of the mesh (face_record.h, adjacency.h), but two corners'
// edge is not one of the mesh's, and two vertices may have several edges between them. No face has
// the same vertex twice: an edge whose flip would lead there stays. So do edges of the boundary,
// those of three faces or more, and those whose flip would leave a face without area, or one with
// a side so short that the face's products do not say how long it is (FaceRecord::loses_length).
//
// Flips work on the lengths of edges, as numbers of two doubles (intrinsic_faces.h), which the two
// faces of an edge share. So whatever rounding does, the faces fit together, and what a flip loses
// is lost once: it does not grow with the flips after it. Faces that did not quite fit together
// would be pulled further apart by each flip over a short edge, by its longest side over its
// shortest: by flips of products in double precision, distances were 1 % off on a flat fan of 200
// slivers, and 30 % on one of 900.
// FaceRecord::error is the larger loss of the two faces before, and that of the flip; it is an
// estimate, far below rounding to double wherever faces are higher than 1e-14 of their length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/shared_array.h"
#include "core/base/vec3.h"
#include "core/surface/face_record.h"
#include "core/surface/triangulation.h"

namespace geodesic {

class IntrinsicDelaunay {
 public:
  // O(edges) on scans; deterministic. Errors: cancelled.
  // `positions` are those of the mesh's vertices.
  [[nodiscard]] static Result<IntrinsicDelaunay> build(const Triangulation& mesh,
                                                       std::span<const Vec3> positions,
                                                       const Cancel& cancel);

  // All that it consists of. Written to a file and read back, it is the same.
  struct Parts {
    SharedArray<FaceRecord> faces;
    SharedArray<std::uint32_t> corner_begin;  // vertex_count + 1
    SharedArray<std::uint32_t> corners;
    bool is_oriented = false;  // as the mesh is: flips keep it so
    bool is_crowded = false;   // likewise
    bool is_even = false;
    bool has_flat_faces = false;  // of the mesh
    double longest2 = 0;          // as in Triangulation
    std::uint64_t flips = 0;
  };
  // `parts` are those of what `build` has made; they are not checked.
  explicit IntrinsicDelaunay(Parts parts) : parts_(std::move(parts)) {}
  [[nodiscard]] const Parts& parts() const { return parts_; }

  // Valid while this object is.
  [[nodiscard]] Triangulation triangulation() const {
    return {parts_.faces,   parts_.corner_begin,   parts_.corners,    parts_.is_oriented,
            parts_.is_even, parts_.has_flat_faces, parts_.is_crowded, false,
            parts_.longest2};
  }

  // Whether the edge of a halfedge may be flipped: it has two faces, and their apexes
  // are two vertices.
  [[nodiscard]] static bool can_flip(const Triangulation& faces, Halfedge h);
  // The sum of the cotangents of the two angles opposite an edge of two faces, times
  // twice the areas of both: negative where the angles add up to more than pi.
  [[nodiscard]] static double excess(const Triangulation& faces, Halfedge h);
  // How much of that may be rounding.
  [[nodiscard]] static double excess_rounding(const Triangulation& faces, Halfedge h);

  [[nodiscard]] std::uint64_t flips() const { return parts_.flips; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  Parts parts_;
};

}  // namespace geodesic
