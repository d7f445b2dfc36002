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

std::string told_name(std::string_view name) {
  // Cut first, so that no more is looked at than is kept; what is no UTF-8 may get longer.
  return cut_to(as_utf8(cut_to(name, kMostNameBytes)), kMostNameBytes);
}

void DecodedMesh::add_part(MeshPart part, std::string_view name) {
  if (++part_count > kMostParts) return;
  part.name = told_name(name);
  parts.push_back(std::move(part));
}

}  // namespace geodesic::proto
