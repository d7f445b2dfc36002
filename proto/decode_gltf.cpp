// Two passes over the instances of the scene. The first resolves each primitive
// once and adds up vertices and faces against the limits; only then is memory
// taken, once, and the second pass writes positions and faces into it.
//
// Faces keep the order and the corners of the file, under mirroring transforms
// too: a client's face and its corners must mean the same here as there.
#include "proto/decode_gltf.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "proto/draco_codec.h"
#include "proto/gltf_accessor.h"
#include "proto/gltf_buffers.h"
#include "proto/gltf_container.h"
#include "proto/gltf_fill.h"
#include "proto/gltf_parse.h"
#include "proto/gltf_scene.h"

namespace geodesic::proto {
namespace {

// A primitive with its bytes found and its counts known.
struct Resolved {
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0;
  GltfElements positions;
  std::optional<GltfElements> indices;
  std::shared_ptr<const TriangleSoup> draco;  // instead of the two above
};

bool draws_triangles(const GltfPrimitive& primitive) { return primitive.mode >= gltf_triangles; }

std::uint64_t faces_of(int mode, std::uint64_t corners) {
  if (mode == gltf_triangles) return corners / 3;
  return corners < 3 ? 0 : corners - 2;
}

std::string name_of_primitive(std::size_t mesh, std::size_t primitive) {
  return "mesh " + std::to_string(mesh) + ", primitive " + std::to_string(primitive);
}

// One sentence for each kind of thing that was ignored: where it was first seen
// and how often.
class Ignored {
 public:
  void add(const std::string& where, const char* what) {
    auto [it, is_new] = first_.try_emplace(what, where, 0);
    if (!is_new) ++it->second.second;
  }

  [[nodiscard]] std::vector<std::string> sentences() const {
    std::vector<std::string> sentences;
    for (const auto& [what, seen] : first_) {
      std::string sentence = seen.first + " " + what;
      if (seen.second > 0) sentence += " (and " + std::to_string(seen.second) + " more)";
      sentences.push_back(sentence + ".");
    }
    return sentences;
  }

 private:
  std::map<std::string, std::pair<std::string, std::uint64_t>> first_;
};

class Assembly {
 public:
  Assembly(const GltfDocument& document, GltfBuffers& buffers, const DecodeLimits& limits,
           std::uint64_t file_bytes)
      : document_(document), buffers_(buffers), limits_(limits), file_bytes_(file_bytes) {
    // Faces refer to vertices by 32 bits.
    limits_.max_vertices = std::min<std::uint64_t>(limits_.max_vertices, 0xFFFFFFFF);
    resolved_.resize(document.meshes.size());
  }

  Result<DecodedMesh> run() {
    auto instances = find_instances(document_, limits_.max_nodes);
    if (!instances) return fail(std::move(instances.error()));
    for (const GltfInstance& instance : *instances) {
      if (const auto counted = count(instance); !counted) return fail(counted.error());
    }
    if (faces_ == 0) return fail(ErrorCode::no_triangles, "The scene has no triangles.");
    DecodedMesh mesh;
    mesh.soup.positions.resize(vertices_);
    mesh.soup.faces.resize(faces_);
    mesh.parts.reserve(parts_);
    Cursor cursor;
    for (const GltfInstance& instance : *instances) {
      if (const auto done = write(instance, mesh, cursor); !done) return fail(done.error());
    }
    mesh.warnings = ignored_.sentences();
    return mesh;
  }

 private:
  struct Cursor {
    std::uint64_t vertex = 0;
    std::uint64_t face = 0;
  };

  // Errors of a primitive's parts name the primitive too.
  static tl::unexpected<Error> in_primitive(Error error, std::size_t mesh, std::size_t primitive) {
    if (error.detail.starts_with("The ")) error.detail[0] = 't';  // amid the sentence now
    error.detail = name_of_primitive(mesh, primitive) + ": " + error.detail;
    return fail(std::move(error));
  }

  Result<void> count(const GltfInstance& instance) {
    const GltfNode& node = document_.nodes[instance.node];
    const std::string node_name = "node " + std::to_string(instance.node);
    if (node.has_skin) ignored_.add(node_name, "has a skin, which is not applied");
    if (node.is_instanced) {
      ignored_.add(node_name, "is drawn once: EXT_mesh_gpu_instancing is not applied");
    }
    const auto& primitives = document_.meshes[instance.mesh].primitives;
    auto& resolved = resolved_[instance.mesh];
    if (resolved.empty()) resolved.resize(primitives.size());
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      if (++visits_ > limits_.max_nodes) {
        return fail_limit(ErrorCode::too_large, "The scene draws too many primitives.",
                          limits_.max_nodes, visits_);
      }
      if (!primitives[i].position) {
        ignored_.add(name_of_primitive(instance.mesh, i), "has no POSITION and is left out");
        continue;
      }
      if (!resolved[i]) {
        auto result = resolve(instance.mesh, i);
        if (!result) return in_primitive(std::move(result.error()), instance.mesh, i);
        resolved[i] = std::move(*result);
      }
      if (const auto within = add(resolved[i]->vertices, resolved[i]->faces); !within) {
        return fail(within.error());
      }
      if (draws_triangles(primitives[i])) ++parts_;
    }
    return {};
  }

  Result<void> add(std::uint64_t vertices, std::uint64_t faces) {
    if (const auto within = check(vertices, faces); !within) return within;
    vertices_ += vertices;
    faces_ += faces;
    return {};
  }

  Result<void> check(std::uint64_t more_vertices, std::uint64_t more_faces) const {
    if (more_vertices > limits_.max_vertices - vertices_) {
      return fail_limit(ErrorCode::too_many_vertices, "The mesh has too many vertices.",
                        limits_.max_vertices, vertices_ + more_vertices);
    }
    if (more_faces > limits_.max_faces - faces_) {
      return fail_limit(ErrorCode::too_many_faces, "The mesh has too many faces.",
                        limits_.max_faces, faces_ + more_faces);
    }
    return {};
  }

  Result<Resolved> resolve(std::size_t mesh, std::size_t index) {
    const GltfPrimitive& primitive = document_.meshes[mesh].primitives[index];
    const std::string name = name_of_primitive(mesh, index);
    if (primitive.has_targets) ignored_.add(name, "has morph targets, which are not applied");
    if (!draws_triangles(primitive)) {
      ignored_.add(name, "draws points or lines: its vertices are kept, but it has no faces");
    }
    return primitive.draco ? resolve_draco(primitive, name) : resolve_plain(primitive, name);
  }

  Result<Resolved> resolve_plain(const GltfPrimitive& primitive, const std::string& name) {
    // Against the limits first: a sparse accessor is copied when it is read.
    const std::uint64_t vertices = document_.accessors[*primitive.position].count;
    const std::uint64_t corners =
        primitive.indices ? document_.accessors[*primitive.indices].count : vertices;
    const std::uint64_t faces = draws_triangles(primitive) ? faces_of(primitive.mode, corners) : 0;
    if (const auto within = check(vertices, faces); !within) return fail(within.error());

    Resolved resolved;
    resolved.vertices = vertices;
    resolved.faces = faces;
    auto positions =
        read_accessor(document_, buffers_, *primitive.position, GltfUse::position, file_bytes_);
    if (!positions) return fail(std::move(positions.error()));
    resolved.positions = std::move(*positions);
    if (!draws_triangles(primitive)) return resolved;
    if (primitive.mode == gltf_triangles && corners % 3 != 0) {
      ignored_.add(name, "has corners that make up no whole triangle, which are left out");
    }
    if (primitive.indices) {
      auto indices =
          read_accessor(document_, buffers_, *primitive.indices, GltfUse::indices, file_bytes_);
      if (!indices) return fail(std::move(indices.error()));
      resolved.indices = std::move(*indices);
    }
    return resolved;
  }

  Result<Resolved> resolve_draco(const GltfPrimitive& primitive, const std::string& name) {
    const GltfAccessor& accessor = document_.accessors[*primitive.position];
    const auto key =
        std::tuple(primitive.draco->view, primitive.draco->position_id, accessor.normalized);
    auto& soup = draco_[key];
    if (soup == nullptr) {
      const auto bytes = buffers_.view(primitive.draco->view);
      if (!bytes) return fail(bytes.error());
      auto decoded =
          decode_draco(*bytes, {limits_.max_vertices - vertices_, limits_.max_faces - faces_},
                       DracoPosition{primitive.draco->position_id, accessor.normalized});
      if (!decoded) return fail(std::move(decoded.error()));
      soup = std::make_shared<const TriangleSoup>(std::move(*decoded));
    }
    if (soup->positions.size() != accessor.count) {
      ignored_.add(name, "has another number of vertices than its accessor says");
    }
    Resolved resolved;
    resolved.vertices = soup->positions.size();
    resolved.faces = draws_triangles(primitive) ? soup->faces.size() : 0;
    resolved.draco = soup;
    return resolved;
  }

  Result<void> write(const GltfInstance& instance, DecodedMesh& mesh, Cursor& cursor) {
    const GltfNode& node = document_.nodes[instance.node];
    const GltfMesh& source = document_.meshes[instance.mesh];
    for (std::size_t i = 0; i < source.primitives.size(); ++i) {
      const GltfPrimitive& primitive = source.primitives[i];
      const auto& resolved = resolved_[instance.mesh][i];
      if (!resolved) continue;
      const std::span<Vec3> positions =
          std::span(mesh.soup.positions).subspan(cursor.vertex, resolved->vertices);
      const std::span<Face> faces =
          std::span(mesh.soup.faces).subspan(cursor.face, resolved->faces);
      const auto base = static_cast<std::uint32_t>(cursor.vertex);
      const auto done = resolved->draco != nullptr
                            ? write_draco(*resolved, instance, positions, faces, base)
                            : write_plain(*resolved, primitive, instance, positions, faces, base);
      if (!done) return in_primitive(done.error(), instance.mesh, i);
      if (draws_triangles(primitive)) {
        mesh.parts.push_back(
            {static_cast<std::int64_t>(instance.node), static_cast<std::int64_t>(instance.mesh),
             static_cast<std::int64_t>(i), node.name.empty() ? source.name : node.name,
             cursor.vertex, resolved->vertices, cursor.face, resolved->faces});
      }
      cursor.vertex += resolved->vertices;
      cursor.face += resolved->faces;
    }
    return {};
  }

  static Result<void> write_plain(const Resolved& resolved, const GltfPrimitive& primitive,
                                  const GltfInstance& instance, std::span<Vec3> positions,
                                  std::span<Face> faces, std::uint32_t base) {
    if (const auto bad = fill_positions(resolved.positions, instance.to_world, positions)) {
      return not_finite(*bad, *primitive.position, instance.node);
    }
    if (!resolved.indices) {
      fill_faces(primitive.mode, base, faces);
      return {};
    }
    const auto bad = fill_faces(*resolved.indices, primitive.mode, base, positions.size(), faces);
    if (!bad) return {};
    std::string detail = "accessor " + std::to_string(*primitive.indices) + ": index " +
                         std::to_string(bad->element) + " is " + std::to_string(bad->value) +
                         ", but there are " + std::to_string(positions.size()) + " vertices.";
    if (bad->is_restart) detail += " (glTF does not allow the primitive restart value.)";
    return fail(ErrorCode::index_out_of_range, std::move(detail));
  }

  static Result<void> write_draco(const Resolved& resolved, const GltfInstance& instance,
                                  std::span<Vec3> positions, std::span<Face> faces,
                                  std::uint32_t base) {
    if (const auto bad = fill_positions(resolved.draco->positions, instance.to_world, positions)) {
      return fail(ErrorCode::mesh_invalid,
                  "the transform of node " + std::to_string(instance.node) + " puts vertex " +
                      std::to_string(bad->element) + " where no number reaches.");
    }
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const Face& face = resolved.draco->faces[f];
      faces[f] = {base + face[0], base + face[1], base + face[2]};
    }
    return {};
  }

  static tl::unexpected<Error> not_finite(const BadPosition& bad, std::size_t accessor,
                                          std::size_t node) {
    const std::string element = std::to_string(bad.element);
    if (bad.in_file) {
      return fail(ErrorCode::mesh_invalid, "accessor " + std::to_string(accessor) + ": position " +
                                               element + " is not finite.");
    }
    return fail(ErrorCode::mesh_invalid,
                "the transform of node " + std::to_string(node) + " puts position " + element +
                    " of accessor " + std::to_string(accessor) + " where no number reaches.");
  }

  const GltfDocument& document_;
  GltfBuffers& buffers_;
  DecodeLimits limits_;
  std::uint64_t file_bytes_;
  std::vector<std::vector<std::optional<Resolved>>> resolved_;  // by mesh and primitive
  std::map<std::tuple<std::size_t, std::uint32_t, bool>, std::shared_ptr<const TriangleSoup>>
      draco_;
  Ignored ignored_;
  std::uint64_t vertices_ = 0;
  std::uint64_t faces_ = 0;
  std::uint64_t visits_ = 0;
  std::size_t parts_ = 0;
};

}  // namespace

Result<DecodedMesh> decode_gltf(std::span<const std::byte> bytes, MeshFormat format,
                                const DecodeLimits& limits) {
  auto container = format == MeshFormat::glb ? open_glb(bytes) : open_gltf(bytes);
  if (!container) return fail(std::move(container.error()));
  if (const auto shape = check_json_shape(container->json, limits); !shape) {
    return fail(shape.error());
  }
  const auto document = parse_gltf(container->json, limits);
  if (!document) return fail(document.error());
  GltfBuffers buffers(*document, container->binary, container->has_binary);
  auto mesh = Assembly(*document, buffers, limits, bytes.size()).run();
  if (!mesh) return mesh;
  mesh->format = format;
  if (container->trailing_bytes != 0) {
    mesh->warnings.push_back(std::to_string(container->trailing_bytes) +
                             " bytes after the end of the GLB are ignored.");
  }
  return mesh;
}

}  // namespace geodesic::proto
