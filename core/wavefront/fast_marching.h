// The distance field of Kimmel and Sethian, "Computing geodesic paths on
// manifolds", PNAS 1998: Dijkstra's order, and a vertex computed from two accepted
// ones of a triangle as if the front that passed them were a straight line (a
// plane wave). The front's curvature is lost, so close to a source the error is of
// the order of an edge; where faces are small beside the distance it vanishes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/vertex_heap.h"
#include "core/surface/adjacency.h"
#include "core/wavefront/virtual_source.h"

namespace geodesic {

// The apex's distance behind a straight front that passes the base's ends at dp and
// dq: the distance as a linear function over the triangle's plane, with a gradient of
// length one that points away from the base. In case (a) the characteristic, back
// from the apex along the gradient, crosses the base at `crossing`. Where it does
// not, or no such function has these two values, the ways along the two sides remain,
// as cases (b) and (c).
//
// With L the base's length and g the gradient,
//   g_x L = dq - dp,   g_y L = sqrt(L^2 - (dq - dp)^2),   d = dp + g . (w - p)
[[nodiscard]] inline Arrival arrive_plane_wave(double dp, double dq, const UnfoldedApex& w) {
  const double base2 = w.base2();
  const double slope = dq - dp;
  const double climb2 = base2 - slope * slope;
  if (!(climb2 > 0)) return arrive_along_sides(dp, dq, w);
  const double climb = std::sqrt(climb2);
  const double meets = w.from_p * climb - w.height * slope;  // crossing * base2 * climb
  if (meets < 0 || meets > base2 * climb) return arrive_along_sides(dp, dq, w);
  const double d = dp + (slope * w.from_p + climb * w.height) / base2;
  return {d, Fig4::a, std::clamp(meets / (base2 * climb), 0.0, 1.0)};
}

// A face with an obtuse angle, seen from there: the plane's origin is the obtuse
// vertex and the x axis leads to `first`. A wave may come over the base and reach the
// vertex before it has reached both ends of the base, so these do not tell of it. The
// splitting section is the part of the plane that sees the vertex at an acute angle
// from both sides; the faces beyond the base are unfolded until a vertex falls into
// it. With that vertex, the far one, the face is two virtual triangles that are
// acute at the obtuse vertex.
struct ObtuseSplit {
  std::uint32_t obtuse;
  std::uint32_t first;   // the ends of the face's base …
  std::uint32_t second;  // …
  std::uint32_t far;     // … and the far vertex; kNone where none was found
  std::array<double, 2> first_at;
  std::array<double, 2> second_at;
  std::array<double, 2> far_at;
};

// The split of a face at its corner c, which must be obtuse. None is found where
// the section leaves the surface, where it meets an edge of more than two faces,
// and where it is so narrow that only a long strip would do.
[[nodiscard]] ObtuseSplit split_obtuse(const Adjacency& adjacency, std::uint32_t face,
                                       std::uint32_t c);

// A straight piece within a face, by the weights of its ends.
struct FaceSegment {
  std::uint32_t face;
  std::array<double, 3> from;
  std::array<double, 3> to;
};

// The edge that the two virtual triangles share, from the obtuse vertex straight
// over the faces to the far one. Empty where there is none.
[[nodiscard]] std::vector<FaceSegment> virtual_edge(const Adjacency& adjacency, std::uint32_t face,
                                                    std::uint32_t c);

// Memory that a query works in, kept for the next query on the same thread.
struct FastMarchingScratch {
  struct Waiting {
    ObtuseSplit split;
    std::uint32_t next;  // with the same far vertex; kNone ends the list
  };
  VertexHeap heap;
  std::vector<std::uint8_t> is_target;
  std::vector<std::uint32_t> split_of_face;  // number in `splits`, or kNone
  std::vector<std::uint32_t> first_by_far;   // by far vertex, number in `splits`
  std::vector<Waiting> splits;
};

// The distances from the nearest of the sources: one front of them all. From a
// source to the vertices of the faces it lies in the way is straight. A distance
// may lie a little above or below the true one, and is never above the way along
// edges, nor below the straight line in space. O(n log n) for n vertices. Errors: cancelled.
[[nodiscard]] Result<Field> fast_marching_field(const Adjacency& adjacency,
                                                std::span<const Source> sources,
                                                const FieldLimits& limits,
                                                FastMarchingScratch& scratch, const Cancel& cancel);

}  // namespace geodesic
