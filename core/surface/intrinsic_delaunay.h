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
// a side so short that the face's products do not say how long it is (FaceRecord::loses_length), or
// lose more of the distances than 1e-11, where sides differ by many powers of ten.
//
// What a flip loses (FaceRecord::error) is an estimate, not a bound. Certain is which edges are
// flipped, that no flip is done by faces of whose sides nothing is left, and that one flip of exact
// faces moves a corner by no more than some roundings of the longest side times that over the
// shortest. Assumed is that losses of flips one after another add up to no more than the larger of
// both faces' and the new one: by the triangle inequality, an old loss could also be turned about a
// short side and grow by the longest over the shortest. Bounds that allow for that grow with each
// flip until they say nothing. So `upper` and `exact` on these faces are right as far as tests show
// (upper_bound_test.cpp, tolerance_promise_test.cpp, against 113 bits), not by proof.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/surface/face_record.h"
#include "core/surface/triangulation.h"

namespace geodesic {

class IntrinsicDelaunay {
 public:
  // O(edges) on scans; deterministic. Errors: cancelled.
  [[nodiscard]] static Result<IntrinsicDelaunay> build(const Triangulation& mesh,
                                                       const Cancel& cancel);

  // Valid while this object is.
  [[nodiscard]] Triangulation triangulation() const {
    return {faces_, corner_begin_, corners_, is_oriented_, is_even_, has_flat_faces_, is_crowded_};
  }

  // Whether the edge of a halfedge may be flipped: it has two faces, and their apexes
  // are two vertices.
  [[nodiscard]] static bool can_flip(const Triangulation& faces, Halfedge h);
  // The sum of the cotangents of the two angles opposite an edge of two faces, times
  // twice the areas of both: negative where the angles add up to more than pi.
  [[nodiscard]] static double excess(const Triangulation& faces, Halfedge h);
  // How much of that may be rounding.
  [[nodiscard]] static double excess_rounding(const Triangulation& faces, Halfedge h);

  [[nodiscard]] std::uint64_t flips() const { return flips_; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  void flip_edges(Poll& poll);
  // Whether it was flipped: not if that would leave a face without area.
  bool flip(Halfedge h);

  std::vector<FaceRecord> faces_;
  std::vector<std::uint32_t> corner_begin_;  // vertex_count + 1
  std::vector<std::uint32_t> corners_;
  bool is_oriented_ = false;  // as the mesh is: flips keep it so
  bool is_crowded_ = false;   // likewise
  bool is_even_ = false;
  bool has_flat_faces_ = false;  // of the mesh
  std::uint64_t flips_ = 0;
};

}  // namespace geodesic
