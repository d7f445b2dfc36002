#include "proto/mesh/metadata.h"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "proto/mesh/mesh_findings.h"
#include "proto/wire/input_codes.h"

namespace geodesic::proto {
namespace {

using nlohmann::ordered_json;

// Names come from the file: what is not UTF-8 is replaced, never an exception.
std::string dumped(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

ordered_json report_of(const DecodedMesh& decoded, const Adjacency& adjacency) {
  ordered_json report = ordered_json::array();
  for (const Finding& finding : decoded.findings) {
    ordered_json examples = ordered_json::array();
    for (const std::string& where : finding.examples) examples.push_back({{"where", where}});
    report.push_back({{"code", finding.code},
                      {"count", finding.count},
                      {"examples", std::move(examples)},
                      {"text", finding.text}});
  }
  for (const MeshFinding& finding : examine(adjacency)) {
    ordered_json examples = ordered_json::array();
    for (const MeshExample& example : finding.examples) {
      examples.push_back(
          {{example.of == MeshExample::Of::face     ? "face"
            : example.of == MeshExample::Of::vertex ? "vertex"
                                                    : "vertices",
            example.of == MeshExample::Of::vertices ? ordered_json(example.numbers)
                                                    : ordered_json(example.numbers.front())}});
    }
    report.push_back({{"code", finding.code},
                      {"count", finding.count},
                      {"examples", std::move(examples)},
                      {"text", finding.text}});
  }
  return report;
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

std::string describe_mesh(std::string_view id, std::uint64_t bytes, const ImportOptions& options,
                          const DecodedMesh& decoded, const Adjacency& adjacency) {
  const Mesh& mesh = adjacency.mesh();
  const TopologyReport& topology = adjacency.report();
  const std::string import = canonical_text(options);
  const Box& box = mesh.box();
  const ordered_json description{
      {"id", id},
      {"bytes", bytes},
      {"format", name_of(decoded.format)},
      {"import", import.empty() ? ordered_json::object() : ordered_json::parse(import)},
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
      {"report", report_of(decoded, adjacency)},
      {"unit", "mesh"}};
  return dumped(description);
}

Result<ImportOptions> import_options_of(const std::string& description) {
  const auto object = ordered_json::parse(description, nullptr, /*allow_exceptions=*/false);
  const auto import = object.is_object() ? object.find("import") : object.end();
  if (import != object.end() && import->is_object()) {
    if (auto parameters = Parameters::from_json(import->dump())) {
      if (auto options = read_import_options(*parameters)) return options;
    }
  }
  return fail(InputCode::store_corrupt, "the stored description of the mesh cannot be read");
}

Result<std::string> with_state(const std::string& description, bool resident, bool prepared) {
  auto object = ordered_json::parse(description, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) {
    return fail(InputCode::store_corrupt, "the stored description of the mesh cannot be read");
  }
  object["state"] = resident ? "resident" : "stored";
  object["prepared"] = prepared;
  return dumped(object);
}

}  // namespace geodesic::proto
