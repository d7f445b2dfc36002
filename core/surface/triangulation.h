// Triangles glued along their edges, whatever surface they cut up: the faces of a mesh,
// or those of its intrinsic Delaunay triangulation. A view; who made it owns the arrays.
#pragma once

#include <cstdint>
#include <span>

#include "core/surface/face_record.h"

namespace geodesic {

struct Triangulation {
  std::span<const FaceRecord> faces;
  std::span<const std::uint32_t> corner_begin;  // vertex_count + 1
  std::span<const std::uint32_t> all_corners;
  // Every edge is in one face, or in two that go along it opposite ways.
  bool is_oriented = false;
  // No side is more than a thousand times as long as another: rounding turns nothing that is
  // unfolded over some dozens of such faces (unfold_rounding.h).
  bool is_even = false;
  // A face is lower than tolerance::kFlat (tolerances.h).
  bool has_flat_faces = false;
  // Some edge is in more than kCrowd faces: copies of a face, or the pages of a book. Asking all of
  // them at each crossing takes the square of their number.
  bool is_crowded = false;
  static constexpr std::size_t kCrowd = 16;
  // A face is a line (unfold_rounding.h).
  bool has_lines = false;
  // The square of the longest side.
  double longest2 = 0;

  // The corners at a vertex, in ascending order.
  [[nodiscard]] std::span<const std::uint32_t> corners(std::uint32_t vertex) const {
    return all_corners.subspan(corner_begin[vertex],
                               corner_begin[vertex + 1] - corner_begin[vertex]);
  }
  // The next halfedge on the same edge; itself on a boundary.
  [[nodiscard]] Halfedge ring(Halfedge h) const { return faces[face_of(h)].ring[corner_of(h)]; }
};

}  // namespace geodesic
