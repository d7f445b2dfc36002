// Straight ahead on a surface: Polthier and Schmies, "Straightest geodesics on
// polyhedral surfaces", in Mathematical Visualization, 1998 (definition 3 and
// section 4): straight in each face and, unfolded, over each edge; at a vertex half
// of its total angle to either side.
//
// Unlike a shortest path, a straightest geodesic exists from every point in every
// direction, and is the only one. It may be far from the shortest path to where it
// ends.
#pragma once

#include <cstdint>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// Faces that one geodesic may cross: a quarter of a second, and 64 MB of points.
inline constexpr std::uint64_t kMostFacesCrossed = 1'000'000;

struct StraightestGeodesic {
  enum class End : std::uint8_t {
    length,        // as long as was asked for
    boundary,      // at an edge with one face, or at a vertex of such an edge
    vertex,        // at a pinched vertex: "half of the angle" means nothing there
    non_manifold,  // at an edge of three faces or more, or at a vertex of one
  };
  Path path;  // from the start; one point when it goes nowhere
  End end = End::length;
  // Of length one, in the plane of the last face: where it was heading. From the end
  // point inside a face, the opposite direction leads back.
  Vec3 direction_at_end;
};

// From a point along the vector `direction` (mesh coordinates, any length) for
// `length` mesh units.
//
// The vector is projected onto the plane of the face. For a point on an edge or at
// a vertex that is the face there, of all that it has, in which there is a direction
// that is closest to the vector in space: its projection where that points into the
// face, else the nearer of the two edges that bound the face at the point. Where the
// closest of all is an edge of the boundary that the vector points away from, the
// surface ends there: the result is one point and End::boundary.
// Errors: value_out_of_range for `direction` (not finite, zero, at a right angle to
// the surface), `length` (negative, not finite), or `from` (at a vertex in no face);
// too_large for `length` when it crosses more than kMostFacesCrossed faces; cancelled.
[[nodiscard]] Result<StraightestGeodesic> straightest_geodesic(const Adjacency& adjacency,
                                                               const SurfacePoint& from,
                                                               Vec3 direction, double length,
                                                               const Cancel& cancel);

// The same by an angle in radians.
//
// In a face or on an edge the angle is measured in the plane of `from.face`, from
// the direction vertex[0] -> vertex[1] towards vertex[2]; on an edge it may point out
// of that face, over the edge.
// At a vertex the angle is measured from an edge of its first face (of all in
// adjacency.corners(): that from its corner c to c + 1) towards that face's other edge
// and on through the fan of faces; negative angles go the other way round. Angles are
// as they are on the surface: all round a vertex is the sum of its faces' angles, and
// what is beyond that wraps. Where the fan ends at a boundary or at a non-manifold
// edge, it does not.
// Errors: as above, and value_out_of_range for `angle` when it is not finite or
// beyond the end of a fan.
[[nodiscard]] Result<StraightestGeodesic> straightest_geodesic_at_angle(const Adjacency& adjacency,
                                                                        const SurfacePoint& from,
                                                                        double angle, double length,
                                                                        const Cancel& cancel);

}  // namespace geodesic
