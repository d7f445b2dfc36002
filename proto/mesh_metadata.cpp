#include "proto/mesh_metadata.h"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace geodesic::proto {
namespace {

using nlohmann::ordered_json;

// Names come from the file: what is not UTF-8 is replaced, never an exception.
std::string dumped(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

ordered_json number_or_null(std::int64_t value) {
  return value < 0 ? ordered_json() : ordered_json(value);
}

ordered_json parts_of(const DecodedMesh& decoded) {
  ordered_json parts = ordered_json::array();
  for (const MeshPart& part : decoded.parts) {
    parts.push_back({{"node", number_or_null(part.node)},
                     {"mesh", number_or_null(part.mesh)},
                     {"primitive", number_or_null(part.primitive)},
                     {"name", part.name},
                     {"first_vertex", part.first_vertex},
                     {"vertex_count", part.vertex_count},
                     {"first_face", part.first_face},
                     {"face_count", part.face_count}});
  }
  return parts;
}

// What the client should know of its own mesh, in words.
ordered_json warnings_of(const DecodedMesh& decoded, const Mesh& mesh,
                         const TopologyReport& topology) {
  ordered_json warnings = ordered_json::array();
  for (const Finding& finding : decoded.findings) warnings.push_back(finding.text);
  const auto warn = [&](std::uint64_t count, const char* one, const char* many,
                        const char* meaning) {
    if (count == 0) return;
    warnings.push_back(std::to_string(count) + (count == 1 ? one : many) + "; " + meaning);
  };
  if (topology.components > 1) {
    warnings.push_back(std::to_string(topology.components) +
                       " components; distances between them are infinite");
  }
  warn(topology.vertices_isolated, " vertex is in no face", " vertices are in no face",
       "nothing reaches them");
  warn(topology.edges_non_manifold, " edge has more than two faces",
       " edges have more than two faces", "distances pass to all of them");
  warn(topology.vertices_pinched, " vertex joins faces that share no edge",
       " vertices join faces that share no edge", "distances pass through them");
  warn(topology.faces_duplicate, " face repeats another", " faces repeat others",
       "this changes no distance");
  warn(mesh.dropped_face_count(), " face has two corners in one place",
       " faces have two corners in one place", "left out, their edges joined");
  return warnings;
}

}  // namespace

std::string describe_mesh(std::string_view id, std::uint64_t bytes, const DecodedMesh& decoded,
                          const Mesh& mesh, const TopologyReport& topology) {
  const Box& box = mesh.box();
  const ordered_json description{
      {"id", id},
      {"bytes", bytes},
      {"format", name_of(decoded.format)},
      {"vertices", mesh.source_vertex_count()},
      {"faces", mesh.source_face_count()},
      {"welded_vertices", mesh.vertex_count()},
      {"components", topology.components},
      {"boundary_loops", topology.boundary_loops},
      {"edges_non_manifold", topology.edges_non_manifold},
      {"faces_degenerate", mesh.dropped_face_count() + mesh.zero_area_face_count()},
      {"bbox",
       {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}}},
      {"area", mesh.area()},
      {"mean_edge", topology.mean_edge},
      {"parts", parts_of(decoded)},
      {"warnings", warnings_of(decoded, mesh, topology)},
      {"unit", "mesh"}};
  return dumped(description);
}

Result<std::string> with_state(const std::string& description, bool resident, bool prepared) {
  auto object = ordered_json::parse(description, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) {
    return fail(ErrorCode::store_corrupt, "the stored description of the mesh cannot be read");
  }
  object["state"] = resident ? "resident" : "stored";
  object["prepared"] = prepared;
  return dumped(object);
}

}  // namespace geodesic::proto
