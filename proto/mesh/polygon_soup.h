// Vertices and faces of any number of corners, as OBJ and PLY files have them, and
// their triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/mesh/triangle_soup.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/mesh/findings.h"

namespace geodesic::proto {

class PolygonSoup {
 public:
  explicit PolygonSoup(const DecodeLimits& limits) : limits_(limits) {}

  // Errors: too_many_vertices.
  [[nodiscard]] Result<void> add_vertex(Vec3 position);
  // A face of at least three corners, which may be vertices yet to come.
  // Errors: too_many_faces, counted as triangles.
  [[nodiscard]] Result<void> add_face(std::span<const std::uint32_t> corners);

  [[nodiscard]] std::uint64_t vertex_count() const { return positions_.size(); }

  // Each face becomes its size less two triangles, side by side in the order of the
  // faces. A convex face is a fan about its first corner, and so is one of more than
  // 256 corners; others are cut ear by ear (Meisters 1975) in the plane of their
  // Newell normal, so that no triangle reaches outside. Leaves nothing behind.
  // Errors: index_out_of_range, naming the face; no_triangles.
  [[nodiscard]] Result<TriangleSoup> triangulated(Findings& findings) &&;

 private:
  const DecodeLimits& limits_;
  std::vector<Vec3> positions_;
  std::vector<std::uint32_t> corners_;
  std::vector<std::uint32_t> sizes_;
  std::uint64_t triangles_ = 0;
};

}  // namespace geodesic::proto
