// A triangulation of the same surface with vertices added where it is flat, so that no face is a
// needle: for meshes of long thin triangles, as CAD programs export, where windows would cross as
// many edges as there are needles in the way. Sharp, Soliman and Crane, "Navigating intrinsic
// triangulations", ACM Transactions on Graphics 38, 2019, section 4: while a face has a
// circumscribed circle that is large for its shortest side, a vertex is put at the circle's centre,
// found by walking there straight over the faces, and edges are flipped until the triangulation is
// Delaunay again. No vertex is nearer to a new one than that circle's radius, so faces become
// larger the farther they are from short edges, and few vertices are added (Ruppert, "A Delaunay
// refinement algorithm for quality 2-dimensional mesh generation", Journal of Algorithms 18, 1995).
// Where the walk meets the boundary, or an edge of three faces or more, that edge is cut in half.
//
// The mesh's vertices keep their numbers; those added come after them. Distances are those over the
// mesh: lengths are numbers of two doubles (intrinsic_faces.h), and nothing is bent.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/shared_array.h"
#include "core/base/vec3.h"
#include "core/surface/intrinsic_delaunay.h"
#include "core/surface/triangulation.h"
#include "core/surface/walk_over_faces.h"

namespace geodesic {

class Adjacency;
class Mesh;

// As Adjacency::build, without a refined surface: for a mesh that is made for one query, and asked
// for nothing that would be faster with it.
[[nodiscard]] Result<Adjacency> build_unrefined(std::shared_ptr<const Mesh> mesh,
                                                const Cancel& cancel);

class RefinedSurface {
 public:
  // A place in a face of the triangulation; weights that are not 0 are at least 1e-13.
  struct Place {
    std::uint32_t face;
    std::array<double, 3> weights;
    // The refined face, unfolded into the plane of the mesh's face. There the corner `corner` of
    // the mesh's face is the origin, and the side that starts at it is on the x axis.
    UnfoldedTriangle laid;
    std::uint32_t corner;
  };

  // Null where it would not be worth it: where straight lines cross not much fewer edges than on
  // `delaunay`, where needles are left when there are twice as many vertices, where many more faces
  // have no width, and on meshes of more than kMostVertices vertices. O(n log n) on machine parts;
  // never more than 110 steps a face. Errors: cancelled, too_much_memory.
  [[nodiscard]] static Result<std::shared_ptr<const RefinedSurface>> build(
      const Triangulation& mesh, const Triangulation& delaunay, std::span<const Vec3> positions,
      const Cancel& cancel);
  static constexpr std::size_t kMostVertices = 50'000;

  // All that it consists of. Written to a file and read back, it is the same.
  struct Parts {
    IntrinsicDelaunay delaunay;  // of all vertices
    // Signposts (Sharp, Soliman and Crane 2019, section 3): of each vertex of the mesh a corner at
    // it, and the direction of the side that starts there, in radians from where the mesh's own
    // directions at the vertex begin. kNone where the faces are not one fan, all wound alike.
    SharedArray<std::uint32_t> first_corner;
    SharedArray<double> first_direction;
  };
  // `parts` are those of what `build` has made; they are not checked.
  explicit RefinedSurface(Parts parts) : parts_(std::move(parts)) {}
  [[nodiscard]] const Parts& parts() const { return parts_; }

  // Valid while this object is.
  [[nodiscard]] Triangulation triangulation() const { return parts_.delaunay.triangulation(); }

  // Where a point inside a face of the mesh, or on an edge, is in this triangulation: in one face,
  // or in those round an edge. Empty where that is not known: where none of the face's corners has
  // directions, or rounding hides the way there.
  [[nodiscard]] std::vector<Place> places_of(const Triangulation& mesh, std::uint32_t face,
                                             const std::array<double, 3>& weights,
                                             Poll& poll) const;

  // Whether all vertices of the mesh have directions: then all points have places, unless rounding
  // hides them, and no straight line meets an edge of three faces.
  [[nodiscard]] bool has_all_directions(const Triangulation& mesh) const;

  // The same direction at a vertex of the mesh, over the mesh's own faces. Nothing where none is
  // known there.
  [[nodiscard]] std::optional<Heading> heading_on_mesh(const Triangulation& mesh,
                                                       const Heading& heading, Poll& poll) const;

  [[nodiscard]] std::size_t bytes() const;

 private:
  [[nodiscard]] std::optional<Place> place_from(const Triangulation& mesh, std::uint32_t corner,
                                                const std::array<double, 3>& weights,
                                                Poll& poll) const;

  Parts parts_;
};

}  // namespace geodesic
