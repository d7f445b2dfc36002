#include "proto/mesh/metadata.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "proto/mesh/mesh_findings.h"
#include "proto/wire/cut_to.h"
#include "proto/wire/input_codes.h"

namespace geodesic::proto {
namespace {

using nlohmann::ordered_json;

// Of a sentence, which may name what is in the file.
constexpr std::size_t kMostTextBytes = 1000;

// Names come from the file: what is not UTF-8 is replaced, never an exception.
std::string dumped(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

ordered_json report_of(const DecodedMesh& decoded, const Adjacency& adjacency) {
  ordered_json report = ordered_json::array();
  for (const Finding& finding : decoded.findings) {
    ordered_json examples = ordered_json::array();
    for (const std::string& where : finding.examples) {
      examples.push_back({{"where", cut_to(where, kMostNameBytes)}});
    }
    report.push_back({{"code", finding.code},
                      {"count", finding.count},
                      {"examples", std::move(examples)},
                      {"text", cut_to(finding.text, kMostTextBytes)}});
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

// What parts and materials take of a description together, the rest is for all else; and of it what
// materials take, which come first.
constexpr std::size_t kMostListedBytes = kMostDescriptionBytes * 7 / 8;
constexpr std::size_t kMostMaterialBytes = kMostDescriptionBytes / 8;

// Adds what they take to `bytes`.
ordered_json materials_of(const DecodedMesh& decoded, std::size_t& bytes) {
  ordered_json materials = ordered_json::array();
  const std::vector<std::uint64_t> counts = decoded.materials.face_counts();
  for (const std::string& name : decoded.materials.names) {
    ordered_json told{{"name", name}, {"face_count", counts[materials.size()]}};
    const std::size_t more = dumped(told).size() + 1;
    if (bytes + more > kMostMaterialBytes) break;
    bytes += more;
    materials.push_back(std::move(told));
  }
  return materials;
}

// `bytes`: what is taken of kMostListedBytes already.
ordered_json parts_of(const DecodedMesh& decoded, std::size_t bytes) {
  ordered_json parts = ordered_json::array();
  for (const MeshPart& part : decoded.parts) {
    ordered_json told{{"node", number_or_null(part.node)},
                      {"mesh", number_or_null(part.mesh)},
                      {"primitive", number_or_null(part.primitive)},
                      {"name", part.name},
                      {"first_vertex", part.first_vertex},
                      {"vertex_count", part.vertex_count},
                      {"first_face", part.first_face},
                      {"face_count", part.face_count},
                      {"material", number_or_null(part.material)}};
    bytes += dumped(told).size() + 1;
    if (parts.size() == kMostParts || bytes > kMostListedBytes) break;
    parts.push_back(std::move(told));
  }
  return parts;
}

ordered_json boundaries_told(std::span<const ToldBoundary> boundaries) {
  ordered_json told = ordered_json::array();
  for (const ToldBoundary& loop : boundaries.first(std::min(boundaries.size(), kMostBoundaries))) {
    told.push_back({{"length", loop.length},
                    {"edges", loop.edges},
                    {"closed", loop.is_closed},
                    {"vertex", loop.vertex}});
  }
  return told;
}

// A sentence for people and for programs.
void add_finding(ordered_json& description, const char* code, std::uint64_t count,
                 const std::string& text) {
  description["warnings"].push_back(text);
  description["report"].push_back(
      {{"code", code}, {"count", count}, {"examples", ordered_json::array()}, {"text", text}});
}

// A description's members once it is known how many materials it lists.
void tell_of_missing_materials(ordered_json& description, const FaceMaterials& materials) {
  const std::size_t listed = description["materials"].size();
  const std::uint64_t faces = materials.faces_beyond(listed);
  if (faces == 0) return;
  add_finding(description, "materials_not_listed", faces,
              std::to_string(faces) +
                  (faces == 1 ? " face has a material that is" : " faces have materials that are") +
                  " not listed: `materials` has the first " + std::to_string(listed) + ".");
}

// A description's members once it is known how many parts it lists.
void tell_of_missing_parts(ordered_json& description, std::uint64_t part_count) {
  const std::size_t listed = description["parts"].size();
  if (listed >= part_count) return;
  const std::string text = std::to_string(part_count - listed) + " of " +
                           std::to_string(part_count) + " parts are not listed: `parts` has the " +
                           "first " + std::to_string(listed) + ". All are in the mesh.";
  description["parts_total"] = part_count;
  add_finding(description, "parts_not_listed", part_count - listed, text);
}

tl::unexpected<Error> unreadable() {
  return fail(InputCode::store_corrupt, "the stored description of the mesh cannot be read");
}

// What the client should know of its own mesh, in words.
ordered_json warnings_of(const DecodedMesh& decoded, const Mesh& mesh,
                         const TopologyReport& topology) {
  ordered_json warnings = ordered_json::array();
  for (const Finding& finding : decoded.findings)
    warnings.push_back(cut_to(finding.text, kMostTextBytes));
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
       "areas count again, and their edges are no boundary");
  warn(mesh.dropped_face_count(), " face has two corners in one place",
       " faces have two corners in one place", "left out, their edges joined");
  return warnings;
}

}  // namespace

std::string describe_mesh(std::string_view id, std::uint64_t bytes, const ImportOptions& options,
                          const DecodedMesh& decoded, const Adjacency& adjacency,
                          std::span<const ToldBoundary> boundaries) {
  const Mesh& mesh = adjacency.mesh();
  const TopologyReport& topology = adjacency.report();
  const std::string import = canonical_text(options);
  const Box& box = mesh.box();
  std::size_t listed_bytes = 0;
  ordered_json materials = materials_of(decoded, listed_bytes);
  ordered_json description{
      {"id", id},
      {"bytes", bytes},
      {"format", name_of(decoded.format)},
      {"import", import.empty() ? ordered_json::object() : ordered_json::parse(import)},
      {"vertices", mesh.source_vertex_count()},
      {"faces", mesh.source_face_count()},
      {"welded_vertices", mesh.vertex_count()},
      {"components", topology.components},
      {"boundary_loops", topology.boundary_loops},
      {"boundaries", boundaries_told(boundaries)},
      {"edges_non_manifold", topology.edges_non_manifold},
      {"faces_degenerate", mesh.dropped_face_count() + mesh.zero_area_face_count()},
      {"bbox",
       {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}}},
      {"area", mesh.area()},
      {"mean_edge", topology.mean_edge},
      {"parts", parts_of(decoded, listed_bytes)},
      {"materials", std::move(materials)},
      {"warnings", warnings_of(decoded, mesh, topology)},
      {"report", report_of(decoded, adjacency)},
      {"unit", "mesh"}};
  tell_of_missing_materials(description, decoded.materials);
  tell_of_missing_parts(description, decoded.part_count);
  return dumped(description);
}

Result<std::string> without_parts(const std::string& description) {
  std::uint64_t parts = 0;
  bool in_parts = false;
  const ordered_json::parser_callback_t keep = [&](int depth, ordered_json::parse_event_t event,
                                                   ordered_json& value) {
    using Event = ordered_json::parse_event_t;
    if (event == Event::key && depth == 1) return !(in_parts = value == "parts");
    if (event == Event::object_start && depth == 2 && in_parts) ++parts;
    return true;
  };
  auto object = ordered_json::parse(description, keep, /*allow_exceptions=*/false);
  const auto is_list = [&](const char* name) {
    const auto found = object.find(name);
    return found != object.end() && found->is_array();
  };
  if (!object.is_object() || !is_list("warnings") || !is_list("report")) return unreadable();
  object["parts"] = ordered_json::array();
  tell_of_missing_parts(object, parts);
  std::string shorter = dumped(object);
  if (shorter.size() > kMostDescriptionBytes) return unreadable();
  return shorter;
}

Result<std::string> with_name(const std::string& description, std::string_view name) {
  auto object = ordered_json::parse(description, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object() || !object.contains("id")) return unreadable();
  ordered_json named;
  for (auto& [key, value] : object.items()) {
    if (key == "name") continue;
    named[key] = std::move(value);
    if (key == "id" && !name.empty()) named["name"] = name;
  }
  return dumped(named);
}

namespace {

// The text that a member is, if it is there.
std::optional<std::string> text_in(const std::string& description, const char* member) {
  const ordered_json::parser_callback_t is_wanted =
      [&](int depth, ordered_json::parse_event_t event, ordered_json& value) {
        return depth != 1 || event != ordered_json::parse_event_t::key || value == member;
      };
  const auto object = ordered_json::parse(description, is_wanted, /*allow_exceptions=*/false);
  const auto text = object.is_object() ? object.find(member) : object.end();
  if (text == object.end() || !text->is_string()) return std::nullopt;
  return text->get<std::string>();
}

}  // namespace

std::optional<std::string> name_in(const std::string& description) {
  return text_in(description, "name");
}

std::string format_in(const std::string& description) {
  return text_in(description, "format").value_or("");
}

Result<ImportOptions> import_options_of(const std::string& description) {
  // All of it is read, and no more than the options is kept.
  const ordered_json::parser_callback_t is_import = [](int depth, ordered_json::parse_event_t event,
                                                       ordered_json& value) {
    return depth != 1 || event != ordered_json::parse_event_t::key || value == "import";
  };
  const auto object = ordered_json::parse(description, is_import, /*allow_exceptions=*/false);
  const auto import = object.is_object() ? object.find("import") : object.end();
  if (import != object.end() && import->is_object()) {
    if (auto parameters = Parameters::from_json(import->dump())) {
      if (auto options = read_import_options(*parameters)) return options;
    }
  }
  return unreadable();
}

Result<ToldParts> parts_in(const std::string& description) {
  const ordered_json::parser_callback_t is_wanted = [](int depth, ordered_json::parse_event_t event,
                                                       ordered_json& value) {
    return depth != 1 || event != ordered_json::parse_event_t::key || value == "parts" ||
           value == "parts_total" || value == "materials";
  };
  const auto object = ordered_json::parse(description, is_wanted, /*allow_exceptions=*/false);
  const auto parts = object.is_object() ? object.find("parts") : object.end();
  if (parts == object.end() || !parts->is_array()) return unreadable();
  ToldParts told;
  told.parts.reserve(parts->size());
  for (const ordered_json& part : *parts) {
    if (!part.is_object()) return unreadable();
    const auto first = part.find("first_face");
    const auto count = part.find("face_count");
    const auto name = part.find("name");
    if (first == part.end() || count == part.end() || name == part.end() ||
        !first->is_number_unsigned() || !count->is_number_unsigned() || !name->is_string()) {
      return unreadable();
    }
    told.parts.push_back({first->get<std::uint64_t>(), count->get<std::uint64_t>(),
                          name->get_ref<const std::string&>()});
  }
  const auto total = object.find("parts_total");
  const bool is_total = total != object.end() && total->is_number_unsigned();
  told.total = is_total ? total->get<std::uint64_t>() : told.parts.size();
  const auto materials = object.find("materials");
  told.has_no_materials = materials != object.end() && materials->empty();
  return told;
}

ToldParts told_parts(const DecodedMesh& decoded) {
  ToldParts told;
  told.parts.reserve(decoded.parts.size());
  for (const MeshPart& part : decoded.parts) {
    told.parts.push_back({part.first_face, part.face_count, part.name});
  }
  told.total = decoded.part_count;
  return told;
}

std::size_t ToldParts::bytes() const {
  std::size_t count = sizeof *this + parts.capacity() * sizeof(ToldPart);
  for (const ToldPart& part : parts) count += part.name.capacity();
  return count;
}

Result<std::string> with_state(const std::string& description, bool resident, bool prepared) {
  if (!description.starts_with('{') || !description.ends_with('}')) return unreadable();
  std::string complete;
  constexpr std::size_t kRoom = 64;
  complete.reserve(description.size() + kRoom);
  complete.append(description, 0, description.size() - 1);
  complete += resident ? R"(,"state":"resident")" : R"(,"state":"stored")";
  complete += prepared ? R"(,"prepared":true})" : R"(,"prepared":false})";
  return complete;
}

}  // namespace geodesic::proto
