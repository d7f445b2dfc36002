// Polylines drawn at random over the faces of a mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "core/refine/refine_along.h"
#include "tests/fixtures/random_meshes.h"

namespace geodesic::fixtures {

inline double length_of(const Mesh& mesh, const SurfacePolyline& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    length += distance(position_of(mesh, line[i - 1]), position_of(mesh, line[i]));
  }
  return length;
}

// From face to face, through vertices, along edges, with points inside faces and points twice.
inline SurfacePolyline random_line(RandomMesh& random, const Adjacency& adjacency,
                                   std::uint32_t steps) {
  SurfacePolyline line;
  std::uint32_t face = random.below(adjacency.mesh().face_count());
  for (std::uint32_t i = 0; i < steps; ++i) {
    std::array<double, 3> bary{random.unit(), random.unit(), random.unit()};
    const double kind = random.unit();
    if (kind < 0.6) bary[random.below(3)] = 0;                     // on an edge
    if (kind < 0.15) bary = {0, 0, 0}, bary[random.below(3)] = 1;  // at a corner
    if (bary[0] + bary[1] + bary[2] == 0) bary[0] = 1;
    const SurfacePoint point = point_on_face(adjacency, face, bary);
    line.push_back(point);
    if (random.unit() < 0.1) line.push_back(point);
    const auto faces = in_all_faces(adjacency, point);
    face = faces[random.below(static_cast<std::uint32_t>(faces.size()))].face;
  }
  if (random.unit() < 0.1) line.resize(1);
  return line;
}

}  // namespace geodesic::fixtures
