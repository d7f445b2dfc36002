// Bytes of a mesh file to triangles. The format is found from the bytes alone:
// GLB, glTF (JSON with embedded data), a Draco bitstream, OBJ, PLY or STL.
//
// The bytes are hostile: nothing outside them is ever opened, every count is
// checked against the bytes present and against `DecodeLimits` before memory is
// taken, and every fault is an `Error` that names it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/triangle_soup.h"
#include "proto/findings.h"
#include "proto/import_options.h"

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
  std::string name;             // the node's name, else the mesh's
  std::uint64_t first_vertex = 0;
  std::uint64_t vertex_count = 0;
  std::uint64_t first_face = 0;
  std::uint64_t face_count = 0;
};

struct DecodedMesh {
  MeshFormat format = MeshFormat::glb;
  TriangleSoup soup;  // in source-vertex order, node transforms applied
  std::vector<MeshPart> parts;
  std::vector<Finding> findings;  // what was ignored or taken otherwise
};

// Which format the bytes claim to be; `format_unknown` when none.
[[nodiscard]] Result<MeshFormat> sniff_format(std::span<const std::byte> bytes);

// Source-vertex order: the default scene depth first (scene 0 when none is
// named, all roots when there is no scene), each mesh's primitives in order, the
// vertices of each primitive's POSITION accessor. Those of points and lines count
// too, but only triangles, strips and fans make faces and parts. Faces keep the
// file's corners in order, under mirroring transforms as well. Draco's vertices
// are in decoded order, those of OBJ and PLY in the order of the file, those of STL
// three a facet.
//
// Of `options`, `scene`, `node`, `up` and `scale` are carried out; welding is for who
// builds the mesh.
//
// Errors: format_unknown, mesh_invalid, no_triangles, index_out_of_range,
// too_many_vertices, too_many_faces, external_uri, extension_required, too_large,
// value_out_of_range (a scene or node that the file does not have).
[[nodiscard]] Result<DecodedMesh> decode_mesh(std::span<const std::byte> bytes,
                                              const DecodeLimits& limits,
                                              const ImportOptions& options = {});

}  // namespace geodesic::proto
