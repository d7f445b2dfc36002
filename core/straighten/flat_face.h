// A face in the plane with a point of it and the directions there: the frame that a
// straightest geodesic is at home in while it crosses the face.
#pragma once

#include <array>
#include <cstdint>
#include <utility>

#include "core/base/vec2.h"
#include "core/base/vec3.h"
#include "core/surface/adjacency.h"
#include "core/surface/face_over_edge.h"
#include "core/surface/point.h"

namespace geodesic {

// The face laid over one of its edges, counterclockwise: corner 0 is the edge's tail
// at the origin, corner 1 its head on the x axis, corner 2 the apex. Corners follow
// each other as in the mesh; corner i here is `corner(i)` there. A point is told by
// its weights at the corners of here.
struct FlatFace {
  std::uint32_t face;
  std::uint32_t first;
  FaceOverEdge over;
  std::array<Vec2, 3> edges;  // unit, corner i to corner i + 1

  FlatFace(const Mesh& mesh, Halfedge base)
      : face(face_of(base)),
        first(corner_of(base)),
        over(face_over_edge(mesh, base)),
        edges{Vec2{1, 0}, unit(over.apex_from_head), unit(-over.apex_from_tail)} {}

  [[nodiscard]] std::uint32_t corner(std::uint32_t i) const { return (first + i) % 3; }
  [[nodiscard]] Halfedge side(std::uint32_t i) const { return halfedge(face, corner(i)); }

  // From a point to the three corners.
  [[nodiscard]] std::array<Vec2, 3> to_corners(const std::array<double, 3>& at) const {
    const Vec2 head{over.length, 0};
    return {-(at[1] * head) - at[2] * over.apex_from_tail,
            at[0] * head - at[2] * over.apex_from_head,
            at[0] * over.apex_from_tail + at[1] * over.apex_from_head};
  }

  [[nodiscard]] SurfacePoint point(const Adjacency& adjacency,
                                   const std::array<double, 3>& at) const {
    std::array<double, 3> bary{};
    for (std::uint32_t i = 0; i < 3; ++i) bary[corner(i)] = at[i];
    return point_on_face(adjacency, face, bary);
  }

  // The axes in space, of length one. A cap, a face of which one corner lies on the side between
  // the others, as CAD programs export, has no plane of its own: it is laid into the plane of the
  // face across that side, or else across another one. Then y points inward all the same. It is
  // zero where a face without area has no such neighbour.
  [[nodiscard]] std::pair<Vec3, Vec3> axes(const Adjacency& adjacency) const;

  // The side that the third corner of a cap lies on, a number of here; kNone for all other faces.
  [[nodiscard]] std::uint32_t side_under_cap() const;
};

}  // namespace geodesic
