// What a mesh file decodes to, and the limits within which it is decoded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/triangle_soup.h"
#include "proto/mesh/face_materials.h"
#include "proto/mesh/findings.h"

namespace geodesic::proto {

enum class MeshFormat : std::uint8_t { glb, gltf, drc, obj, ply, stl };

// "glb", "gltf", "drc", "obj", "ply" or "stl".
[[nodiscard]] std::string_view name_of(MeshFormat format);

struct DecodeLimits {
  std::uint64_t max_vertices = 20'000'000;
  std::uint64_t max_faces = 40'000'000;
  std::uint64_t max_nodes = 1'000'000;  // nodes and primitives drawn, instances counted each time
  // Nodes, accessors, primitives … that a glTF document lists: each costs up to a
  // kilobyte when parsed.
  std::uint64_t max_gltf_objects = 300'000;
  std::uint64_t max_json_depth = 64;          // nesting of the glTF document
  std::uint64_t max_json_values = 5'000'000;  // values in it: each may cost 100 bytes when parsed
};

// One drawn instance of one primitive: a run of source vertices and faces.
struct MeshPart {
  std::int64_t node = -1;       // glTF node; -1: none (Draco)
  std::int64_t mesh = -1;       // glTF mesh
  std::int64_t primitive = -1;  // index within the mesh
  std::string name;             // the node's name, else the mesh's; of kMostNameBytes at most
  std::uint64_t first_vertex = 0;
  std::uint64_t vertex_count = 0;
  std::uint64_t first_face = 0;
  std::uint64_t face_count = 0;
  std::int64_t material = -1;  // of all its faces, its place in the file; -1: none, or several
};

// Of a file's parts, those that are kept and told of: the first ones. A file of megabytes can
// draw a million.
inline constexpr std::size_t kMostParts = 10'000;
// Of a name in a file.
inline constexpr std::size_t kMostNameBytes = 200;

// Such a name as clients read it and say it again: UTF-8, cut to kMostNameBytes.
[[nodiscard]] std::string told_name(std::string_view name);

struct DecodedMesh {
  MeshFormat format = MeshFormat::glb;
  TriangleSoup soup;             // in source-vertex order, node transforms applied
  std::vector<MeshPart> parts;   // the first kMostParts
  std::uint64_t part_count = 0;  // of the file
  FaceMaterials materials;
  std::vector<Finding> findings;  // what was ignored or taken otherwise

  // Counts a part, and keeps it under that name if it is one of the first.
  void add_part(MeshPart part, std::string_view name);
};

}  // namespace geodesic::proto
