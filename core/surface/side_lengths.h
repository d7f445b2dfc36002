// The lengths of the sides of faces that flips have made, and a flip of an edge in terms of them.
#pragma once

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

// For each face: its sides as the mesh has them, until they are set. Those of different blocks
// (base/team.h) may be asked for and set by different threads.
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

}  // namespace geodesic
