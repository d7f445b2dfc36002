// On which side of a closed line the places of a surface are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/refine/refine_along.h"
#include "core/refine/refinement.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

class LineSides {
 public:
  // `line`: its last point is at the place of the first. The surface may be one that other lines
  // have split and cut. What is inside is as faces_inside has it: but for the largest of the parts
  // beside the line, all of them. What hangs on these parts by a vertex alone is outside.
  // Errors: value_out_of_range (the line does not separate the surface, or two points in a row of
  // it are in no face together), too_large (more than `most_vertices` crossings of edges),
  // cancelled, too_much_memory.
  [[nodiscard]] static Result<LineSides> find(const Adjacency& surface, const SurfacePolyline& line,
                                              std::uint64_t most_vertices, const Cancel& cancel);

  // False on the line.
  [[nodiscard]] bool is_inside(std::uint32_t vertex) const { return vertices_[vertex] != 0; }
  [[nodiscard]] const std::vector<std::uint8_t>& vertices() const { return vertices_; }
  // The same of any place; next to the line by less than kSnap it may be either. Of no use if the
  // poll says to stop.
  [[nodiscard]] bool is_inside(const SurfacePoint& point, Poll& poll) const;

  [[nodiscard]] std::size_t bytes() const {
    return vertices_.capacity() + whole_faces_.capacity() + pieces_.capacity() +
           refinement_.bytes();
  }

 private:
  std::vector<std::uint8_t> vertices_;
  std::vector<std::uint8_t> whole_faces_;  // by face of the surface; of no use where that is split
  std::vector<std::uint8_t> pieces_;       // by face of the refined mesh
  Refinement refinement_;                  // of the surface's faces
};

}  // namespace geodesic
