// A face laid into the plane over one of its edges, from the positions of its
// vertices.
//
// Every length is taken from the two positions that it lies between, and each
// corner is told from the nearer one. So a needle's short edge keeps its direction
// to the last bits, which the differences of dot products would lose.
#pragma once

#include "core/base/vec2.h"
#include "core/base/vec3.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// The edge's tail at the origin, its head at (length, 0), the face above it.
struct FaceOverEdge {
  double length;        // of the edge; not zero
  Vec2 apex_from_tail;  // the third vertex, seen from the tail …
  Vec2 apex_from_head;  // … and from the head; y is the height, not negative
};

[[nodiscard]] inline FaceOverEdge face_over_edge(const Mesh& mesh, Halfedge h) {
  const Triangle& t = mesh.faces()[face_of(h)];
  const std::uint32_t c = corner_of(h);
  const Vec3 tail = mesh.positions()[t[c]];
  const Vec3 head = mesh.positions()[t[next_corner(c)]];
  const Vec3 apex = mesh.positions()[t[previous_corner(c)]];
  const Vec3 edge = head - tail;
  const Vec3 to_tail = apex - tail;
  const Vec3 to_head = apex - head;
  const double length = norm(edge);
  // Over the shorter of the two sides, where rounding weighs less.
  const bool tail_is_nearer = dot(to_tail, to_tail) <= dot(to_head, to_head);
  const double height = norm(cross(edge, tail_is_nearer ? to_tail : to_head)) / length;
  return {length, {dot(edge, to_tail) / length, height}, {dot(edge, to_head) / length, height}};
}

}  // namespace geodesic
