// Two passes over the instances of the scene. The first finds each primitive's
// geometry once and adds up vertices and faces against the limits; only then is
// memory taken, once, and the second pass writes positions and faces into it.
//
// Faces keep the order and the corners of the file, under mirroring transforms
// too: a client's face and its corners must mean the same here as there.
#include "proto/gltf/decode.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "proto/gltf/faults.h"
#include "proto/gltf/fill.h"
#include "proto/gltf/geometry.h"
#include "proto/gltf/morph.h"
#include "proto/gltf/scene.h"
#include "proto/gltf_file/buffers.h"
#include "proto/gltf_file/container.h"
#include "proto/gltf_file/parse.h"

namespace geodesic::proto {
namespace {

class Assembly {
 public:
  Assembly(const GltfDocument& document, GltfBuffers& buffers, const DecodeLimits& limits,
           const ImportOptions& options, std::uint64_t file_bytes)
      : document_(document),
        buffers_(buffers),
        limits_(limits),
        options_(options),
        file_bytes_(file_bytes),
        geometries_(document, buffers, file_bytes, findings_) {
    // Faces refer to vertices by 32 bits.
    room_.max_vertices = std::min<std::uint64_t>(limits.max_vertices, 0xFFFFFFFF);
    room_.max_faces = limits.max_faces;
  }

  Result<DecodedMesh> run() {
    auto instances = find_instances(document_, buffers_, options_, limits_, file_bytes_);
    if (!instances) return fail(std::move(instances.error()));
    for (const GltfInstance& instance : *instances) {
      if (const auto counted = count(instance); !counted) return fail(counted.error());
    }
    if (room_.faces == 0) {
      if (const auto sound = find_fault(document_, buffers_, file_bytes_, limits_); !sound) {
        return fail(sound.error());
      }
      return fail(no_triangles());
    }
    DecodedMesh mesh;
    mesh.soup.positions.resize(room_.vertices);
    mesh.soup.faces.resize(room_.faces);
    mesh.parts.reserve(std::min(parts_, kMostParts));
    mesh.materials.names = document_.material_names;
    Cursor cursor;
    for (const GltfInstance& instance : *instances) {
      if (const auto done = write(instance, mesh, cursor); !done) return fail(done.error());
    }
    if (document_.has_rtc_center) {
      findings_.add("rtc_center_not_added", "The scene",
                    "is placed by CESIUM_RTC: positions stay relative to its center");
    }
    mesh.findings = findings_.done();
    return mesh;
  }

 private:
  struct Cursor {
    std::uint64_t vertex = 0;
    std::uint64_t face = 0;
  };

  [[nodiscard]] Error no_triangles() const {
    const char* detail =
        options_.node ? "The node draws no triangles." : "The scene has no triangles.";
    return {ErrorCode::no_triangles, detail, {}, {}, {}};
  }

  Result<void> count(const GltfInstance& instance) {
    const GltfNode& node = document_.nodes[instance.node];
    const std::string node_name = "node " + std::to_string(instance.node);
    if (node.has_skin) {
      findings_.add("skin_at_bind_pose", node_name,
                    "has a skin, which is not applied: its vertices are where the file has them, "
                    "at bind pose, moved by the node's transform");
    }
    const GltfMesh& mesh = document_.meshes[instance.mesh];
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
      if (++visits_ > limits_.max_nodes) {
        return fail_limit(ErrorCode::too_large, "The scene draws too many primitives.",
                          limits_.max_nodes, visits_);
      }
      const auto geometry = geometries_.find(instance.mesh, i, room_);
      if (!geometry) return fail(geometry.error());
      if (*geometry == nullptr) continue;
      if (auto within = room_.check((*geometry)->vertices, (*geometry)->faces); !within) {
        return within;
      }
      room_.vertices += (*geometry)->vertices;
      room_.faces += (*geometry)->faces;
      if (draws_triangles(mesh.primitives[i])) ++parts_;
      if (auto within = count_targets(node, mesh, instance.mesh, i, (*geometry)->vertices);
          !within) {
        return within;
      }
    }
    return {};
  }

  // Many targets may share one accessor, and many nodes the targets: their work is not bounded by
  // the bytes. One that moves nothing is looked at, and counts as one that moves a vertex.
  Result<void> count_targets(const GltfNode& node, const GltfMesh& mesh, std::size_t mesh_index,
                             std::size_t index, std::uint64_t vertices) {
    const GltfPrimitive& primitive = mesh.primitives[index];
    if (primitive.targets.empty()) return {};
    findings_.add("morph_at_default_weights", name_of_primitive(mesh_index, index),
                  "has morph targets, which are taken at their default weights");
    const std::uint64_t looked_at =
        std::min(primitive.targets.size(), weights_of_targets(node, mesh).size());
    const std::uint64_t active = active_targets(node, mesh, primitive).size();
    morphed_ += vertices * active + (looked_at - active);
    const std::uint64_t most = 16 * limits_.max_vertices;
    if (morphed_ <= most) return {};
    return fail_limit(ErrorCode::too_large,
                      "The morph targets are too many, or move too many vertices.", most, morphed_);
  }

  Result<void> write(const GltfInstance& instance, DecodedMesh& mesh, Cursor& cursor) {
    const GltfNode& node = document_.nodes[instance.node];
    const GltfMesh& source = document_.meshes[instance.mesh];
    for (std::size_t i = 0; i < source.primitives.size(); ++i) {
      const GltfPrimitive& primitive = source.primitives[i];
      const GltfGeometry* geometry = geometries_.found(instance.mesh, i);
      if (geometry == nullptr) continue;
      const std::span<Vec3> positions =
          std::span(mesh.soup.positions).subspan(cursor.vertex, geometry->vertices);
      const std::span<Face> faces =
          std::span(mesh.soup.faces).subspan(cursor.face, geometry->faces);
      const auto base = static_cast<std::uint32_t>(cursor.vertex);
      auto done = write_positions(*geometry, primitive, instance, positions);
      if (done) done = write_faces(*geometry, primitive, positions.size(), faces, base);
      if (!done) return in_primitive(done.error(), instance.mesh, i);
      if (draws_triangles(primitive)) {
        MeshPart part{static_cast<std::int64_t>(instance.node),
                      static_cast<std::int64_t>(instance.mesh),
                      static_cast<std::int64_t>(i),
                      {},
                      cursor.vertex,
                      geometry->vertices,
                      cursor.face,
                      geometry->faces,
                      material_of(primitive, instance.mesh, i)};
        mesh.materials.add_faces(part.face_count, part.material < 0
                                                      ? kNoMaterial
                                                      : static_cast<std::uint32_t>(part.material));
        mesh.add_part(std::move(part), node.name.empty() ? source.name : node.name);
      }
      cursor.vertex += geometry->vertices;
      cursor.face += geometry->faces;
    }
    return {};
  }

  // Its place among the file's; -1: none.
  [[nodiscard]] std::int64_t material_of(const GltfPrimitive& primitive, std::size_t mesh,
                                         std::size_t index) {
    if (!primitive.material) return -1;
    if (*primitive.material < document_.materials) {
      return static_cast<std::int64_t>(*primitive.material);
    }
    findings_.add("material_not_there", name_of_primitive(mesh, index),
                  "names a material that the file does not have, and is taken to have none");
    return -1;
  }

  Result<void> write_positions(const GltfGeometry& geometry, const GltfPrimitive& primitive,
                               const GltfInstance& instance, std::span<Vec3> out) {
    const auto targets =
        active_targets(document_.nodes[instance.node], document_.meshes[instance.mesh], primitive);
    // Targets move positions in the primitive's own space.
    const GltfTransform first = targets.empty() ? instance.to_world : GltfTransform{};
    const auto bad = geometry.draco != nullptr
                         ? fill_positions(geometry.draco->positions, first, out)
                         : fill_positions(geometry.positions, first, out);
    if (bad) return not_finite(*bad, *primitive.position, instance.node);
    if (targets.empty()) return {};
    if (auto added = add_targets(document_, buffers_, targets, file_bytes_, out); !added) {
      return added;
    }
    if (const auto still_bad = fill_positions(std::span<const Vec3>(out), instance.to_world, out)) {
      return not_finite({still_bad->element, false}, *primitive.position, instance.node);
    }
    return {};
  }

  static Result<void> write_faces(const GltfGeometry& geometry, const GltfPrimitive& primitive,
                                  std::uint64_t vertices, std::span<Face> out, std::uint32_t base) {
    if (geometry.draco != nullptr) {
      for (std::size_t f = 0; f < out.size(); ++f) {
        const Face& face = geometry.draco->faces[f];
        out[f] = {base + face[0], base + face[1], base + face[2]};
      }
      return {};
    }
    if (!geometry.indices) {
      fill_faces(primitive.mode, base, out);
      return {};
    }
    const auto bad = fill_faces(*geometry.indices, primitive.mode, base, vertices, out);
    if (!bad) return {};
    std::string detail = "accessor " + std::to_string(*primitive.indices) + ": index " +
                         std::to_string(bad->element) + " is " + std::to_string(bad->value) +
                         ", but there are " + std::to_string(vertices) + " vertices.";
    if (bad->is_restart) detail += " (glTF does not allow the primitive restart value.)";
    return fail(ErrorCode::index_out_of_range, std::move(detail));
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
  const DecodeLimits& limits_;
  const ImportOptions& options_;
  std::uint64_t file_bytes_;
  Findings findings_;
  GltfGeometries geometries_;
  GltfRoom room_;
  std::uint64_t visits_ = 0;
  std::uint64_t morphed_ = 0;
  std::size_t parts_ = 0;
};

}  // namespace

Result<DecodedMesh> decode_gltf(std::span<const std::byte> bytes, MeshFormat format,
                                const DecodeLimits& limits, const ImportOptions& options) {
  auto container = format == MeshFormat::glb ? open_glb(bytes) : open_gltf(bytes);
  if (!container) return fail(std::move(container.error()));
  if (const auto shape = check_json_shape(container->json, limits); !shape) {
    return fail(shape.error());
  }
  const auto document = parse_gltf(container->json, limits);
  if (!document) return fail(document.error());
  // What all accessors of the largest mesh can need: positions and indices of 4 bytes.
  const std::uint64_t max_decompressed = 12 * (limits.max_vertices + limits.max_faces);
  GltfBuffers buffers(*document, container->binary, container->has_binary, max_decompressed);
  auto mesh = Assembly(*document, buffers, limits, options, bytes.size()).run();
  if (!mesh) return mesh;
  mesh->format = format;
  if (container->trailing_bytes != 0) {
    mesh->findings.push_back({"trailing_bytes",
                              container->trailing_bytes,
                              {},
                              std::to_string(container->trailing_bytes) +
                                  " bytes after the end of the GLB are ignored."});
  }
  return mesh;
}

}  // namespace geodesic::proto
