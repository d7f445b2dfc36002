#include "proto/mesh/decoded_mesh.h"

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

}  // namespace geodesic::proto
