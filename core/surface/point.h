// One type for every location on a surface: sources, targets and path points.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/mesh/mesh.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// A point given by the barycentric weights of a face's three corners. A point
// at a vertex says so in `vertex`, and then `face` is any face there, or kNone
// at an isolated vertex. A point on an edge has one weight that is exactly zero.
struct SurfacePoint {
  std::uint32_t face = kNone;
  std::array<double, 3> bary{1, 0, 0};
  std::uint32_t vertex = kNone;

  [[nodiscard]] bool at_vertex() const { return vertex != kNone; }
};

// Whether both say so in the same way: a point on an edge is said otherwise in the other face.
[[nodiscard]] inline bool is_same_place(const SurfacePoint& a, const SurfacePoint& b) {
  return a.vertex == b.vertex && (a.at_vertex() || (a.face == b.face && a.bary == b.bary));
}

[[nodiscard]] SurfacePoint point_at_vertex(const Adjacency& adjacency, std::uint32_t vertex);

// A point of a face; weights that leave only one corner make it that vertex.
// The weights must be finite, not negative, and not all zero; they are divided
// by their sum.
[[nodiscard]] SurfacePoint point_on_face(const Adjacency& adjacency, std::uint32_t face,
                                         std::array<double, 3> bary);

// The same of a place that somebody gives or searches for: a weight below 1e-13 of the largest is
// what rounding leaves, and taken as zero. Fronts that set out so near to a vertex or an edge would
// not get round it.
[[nodiscard]] SurfacePoint snapped_point(const Adjacency& adjacency, std::uint32_t face,
                                         std::array<double, 3> bary);

[[nodiscard]] Vec3 position_of(const Mesh& mesh, const SurfacePoint& point);

// How far it is straight from a point of a face to the face's corner c. From the corner's point of
// view: differences of positions have the mesh's digits, however far it lies from the origin, and
// the point's own position has not.
[[nodiscard]] double distance_to_corner(const Mesh& mesh, const SurfacePoint& point,
                                        std::uint32_t c);

// The edge that a point lies inside of, as a halfedge of its face; kNone at a vertex and inside a
// face.
[[nodiscard]] inline Halfedge edge_under(const SurfacePoint& point) {
  for (std::uint32_t c = 0; c < 3 && !point.at_vertex(); ++c) {
    if (point.bary[previous_corner(c)] == 0) return halfedge(point.face, c);
  }
  return kNone;
}

// Every face that the point lies in, with its weights there: one for an inner
// point, the faces round an edge, or those round a vertex (none at an isolated one).
[[nodiscard]] std::vector<SurfacePoint> in_all_faces(const Adjacency& adjacency,
                                                     const SurfacePoint& point);

// The same point as one of `face`, or nothing when it is not in that face.
[[nodiscard]] std::optional<SurfacePoint> seen_from_face(const Adjacency& adjacency,
                                                         const SurfacePoint& point,
                                                         std::uint32_t face);

}  // namespace geodesic
