#include "proto/mesh/decoded_mesh.h"

#include <utility>

#include "proto/wire/cut_to.h"

namespace geodesic::proto {

std::string_view name_of(MeshFormat format) {
  switch (format) {
    case MeshFormat::glb:
      return "glb";
    case MeshFormat::gltf:
      return "gltf";
    case MeshFormat::drc:
      return "drc";
    case MeshFormat::obj:
      return "obj";
    case MeshFormat::ply:
      return "ply";
    case MeshFormat::stl:
      return "stl";
  }
  return "";
}

void DecodedMesh::add_part(MeshPart part, std::string_view name) {
  if (++part_count > kMostParts) return;
  part.name = cut_to(name, kMostNameBytes);
  parts.push_back(std::move(part));
}

}  // namespace geodesic::proto
