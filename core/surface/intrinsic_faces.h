// Faces that cut a surface up anew: the lengths of their sides, and what changes the faces and not
// the surface. An edge is flipped; a vertex is put into a face or on an edge, where the surface is
// flat. All of it goes by the lengths alone, for the new faces lie nowhere in space.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/double_double.h"
#include "core/base/vec3.h"
#include "core/surface/face_record.h"

namespace geodesic {

// Squared: side c is vertex[c] - vertex[c + 1].
using SquaredSides = std::array<DoubleDouble, 3>;

// For each face: its sides as the mesh has them, until they are set. A face that the mesh has not
// has none until then. Those of different blocks (base/team.h) may be asked for and set by
// different threads.
class SideLengths {
 public:
  SideLengths(std::span<const Vec3> positions, std::size_t face_count, Poll& poll);

  [[nodiscard]] SquaredSides squared(std::uint32_t face, const FaceRecord& record) const;
  void set(std::uint32_t face, const SquaredSides& sides);
  // Whether so many faces more can be set in the block without taking memory.
  [[nodiscard]] bool has_room(std::size_t block, std::size_t faces) const {
    return sides_[block].capacity() - sides_[block].size() >= faces;
  }

 private:
  std::span<const Vec3> positions_;
  std::vector<std::uint32_t> place_;  // of each face in its block's `sides_`; kNone: as in the mesh
  std::vector<std::vector<SquaredSides>> sides_;
};

// Two triangles with an edge a - b, and their other corners c and d: squared lengths.
struct Quad {
  DoubleDouble ab2;
  DoubleDouble bc2;
  DoubleDouble ca2;
  DoubleDouble ad2;
  DoubleDouble bd2;
};

// The same, cut along c - d instead: the triangles (a, d, c) and (b, c, d).
struct Flipped {
  DoubleDouble cd2;
  bool is_convex;  // c - d passes between a and b, as far as rounding to double tells
  // As FaceRecord has them, of either triangle.
  std::array<double, 3> dot_a;
  std::array<double, 3> dot_b;
  double area_a;
  double area_b;
  // How far a corner may be from its place by the rounding of this flip, of the longest side.
  double error;
};
// Needs ab2 > 0.
[[nodiscard]] Flipped flip_diagonal(const Quad& quad);

// The edge of `h` and the face across it, a - b with the apexes c and d, becomes the edge d - c:
//
//        c                  c
//      / h \              / | \       face of h:      (a, d, c)
//     a --- b     ->     a  |  b      face across:    (b, c, d)
//      \   /              \ | /
//        d                  d
//
// Whether it was done: not if that would leave a face without area, or a side that the face's
// products do not tell, or if one of the four sides is in very many faces. For an edge that
// IntrinsicDelaunay::can_flip.
bool flip_edge(std::span<FaceRecord> faces, Halfedge h, SideLengths& lengths);

// Whether an edge is the longest side of two faces without width, which lie on each other.
[[nodiscard]] bool is_between_flats(std::span<const FaceRecord> faces, Halfedge h);

// Puts vertex `v` into face f = (a, b, c), at these barycentric weights, all above 0. The faces are
// then f: (a, b, v), and the two at `new_faces` and after it: (b, c, v) and (c, a, v). All three
// have room in `faces` and `lengths`. Whether it was done: not if a side is in very many faces.
bool put_into_face(std::span<FaceRecord> faces, std::uint32_t f, double weight_b, double weight_c,
                   std::uint32_t v, std::uint32_t new_faces, SideLengths& lengths);

// Puts vertex `v` in the middle of an edge, whose halfedges are all of `ring`. Of the face of
// ring[i], with the apex z over x - y, are left (x, v, z), at the same corners, and in face
// `new_faces` + i, likewise, (v, y, z). Whether it was done, as above.
bool put_on_edge(std::span<FaceRecord> faces, std::span<const Halfedge> ring, std::uint32_t v,
                 std::uint32_t new_faces, SideLengths& lengths);

// How often edges may be flipped. Flipping ends by itself; on scans each edge is flipped 0.2 times,
// on machine parts each face some 20. On a flat region that is cut up over its outline, as the caps
// of a tube, each face takes one flip for some 50 corners of an outline: 90 where there are 5,000.
// Whatever rounding makes of the slivers, it ends here.
[[nodiscard]] constexpr std::uint64_t most_flips(std::uint64_t face_count) {
  constexpr std::uint64_t kOfFace = 64;
  constexpr std::uint64_t kOfFaceOfFew = 110;
  constexpr std::uint64_t kOfFew = 4'400'000;
  return std::max(kOfFace * face_count, std::min(kOfFaceOfFew * face_count, kOfFew));
}

}  // namespace geodesic
