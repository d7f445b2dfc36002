// The mesh of a file that knows no parts: one part, which is all of it.
#pragma once

#include <string_view>
#include <utility>

#include "core/mesh/triangle_soup.h"
#include "proto/mesh/decoded_mesh.h"

namespace geodesic::proto {

[[nodiscard]] inline DecodedMesh mesh_of_one_part(MeshFormat format, TriangleSoup soup,
                                                  std::string_view name = {}) {
  DecodedMesh mesh;
  mesh.format = format;
  MeshPart part;
  part.vertex_count = soup.positions.size();
  part.face_count = soup.faces.size();
  mesh.add_part(std::move(part), name);
  mesh.soup = std::move(soup);
  return mesh;
}

}  // namespace geodesic::proto
