#include "proto/gltf/geometry.h"

#include <utility>

#include "proto/draco/codec.h"
#include "proto/gltf/faults.h"

namespace geodesic::proto {
namespace {

std::uint64_t faces_of(int mode, std::uint64_t corners) {
  if (mode == gltf_triangles) return corners / 3;
  return corners < 3 ? 0 : corners - 2;
}

}  // namespace

bool draws_triangles(const GltfPrimitive& primitive) { return primitive.mode >= gltf_triangles; }

std::string name_of_primitive(std::size_t mesh, std::size_t primitive) {
  return "mesh " + std::to_string(mesh) + ", primitive " + std::to_string(primitive);
}

tl::unexpected<Error> in_primitive(Error error, std::size_t mesh, std::size_t primitive) {
  if (error.detail.starts_with("The ")) error.detail[0] = 't';  // amid the sentence now
  error.detail = name_of_primitive(mesh, primitive) + ": " + error.detail;
  return fail(std::move(error));
}

Result<void> GltfRoom::check(std::uint64_t more_vertices, std::uint64_t more_faces) const {
  if (more_vertices > max_vertices - vertices) {
    return fail_limit(ErrorCode::too_many_vertices, "The mesh has too many vertices.", max_vertices,
                      vertices + more_vertices);
  }
  if (more_faces > max_faces - faces) {
    return fail_limit(ErrorCode::too_many_faces, "The mesh has too many faces.", max_faces,
                      faces + more_faces);
  }
  return {};
}

GltfGeometries::GltfGeometries(const GltfDocument& document, GltfBuffers& buffers,
                               std::uint64_t file_bytes, Findings& findings)
    : document_(document),
      buffers_(buffers),
      file_bytes_(file_bytes),
      findings_(findings),
      known_(document.meshes.size()) {}

Result<const GltfGeometry*> GltfGeometries::find(std::size_t mesh, std::size_t index,
                                                 const GltfRoom& room) {
  const auto& primitives = document_.meshes[mesh].primitives;
  const GltfPrimitive& primitive = primitives[index];
  const std::string name = name_of_primitive(mesh, index);
  if (!primitive.position) {
    findings_.add("primitive_left_out", name, "has no POSITION and is left out");
    return nullptr;
  }
  auto& known = known_[mesh];
  if (known.empty()) known.resize(primitives.size());
  if (!known[index]) {
    if (!draws_triangles(primitive)) {
      findings_.add("points_or_lines", name,
                    "draws points or lines: its vertices are kept, but it has no faces");
    }
    auto read_now =
        primitive.draco ? read_draco(primitive, name, room) : read(primitive, name, room);
    if (!read_now) return in_primitive(std::move(read_now.error()), mesh, index);
    known[index] = std::move(*read_now);
  }
  return &*known[index];
}

const GltfGeometry* GltfGeometries::found(std::size_t mesh, std::size_t index) const {
  const auto& known = known_[mesh];
  return known.empty() || !known[index] ? nullptr : &*known[index];
}

Result<GltfGeometry> GltfGeometries::read(const GltfPrimitive& primitive, const std::string& name,
                                          const GltfRoom& room) {
  // Against the limits first: a sparse accessor is copied when it is read.
  const std::uint64_t vertices = document_.accessors[*primitive.position].count;
  const std::uint64_t corners =
      primitive.indices ? document_.accessors[*primitive.indices].count : vertices;
  const std::uint64_t faces = draws_triangles(primitive) ? faces_of(primitive.mode, corners) : 0;
  if (const auto within = room.check(vertices, faces); !within) return fail(within.error());

  GltfGeometry geometry;
  geometry.vertices = vertices;
  geometry.faces = faces;
  auto positions =
      read_accessor(document_, buffers_, *primitive.position, GltfUse::position, file_bytes_);
  if (!positions) return fail(std::move(positions.error()));
  if (!check_bounds(document_, *primitive.position, *positions)) {
    findings_.add("bounds_differ", name,
                  "has other positions than the `min` and `max` of its accessor say, which are "
                  "not used");
  }
  geometry.positions = std::move(*positions);
  if (!draws_triangles(primitive)) return geometry;
  if (primitive.mode == gltf_triangles && corners % 3 != 0) {
    findings_.add("corners_left_out", name,
                  "has corners that make up no whole triangle, which are left out");
  }
  if (primitive.indices) {
    auto indices =
        read_accessor(document_, buffers_, *primitive.indices, GltfUse::indices, file_bytes_);
    if (!indices) return fail(std::move(indices.error()));
    geometry.indices = std::move(*indices);
  }
  return geometry;
}

Result<GltfGeometry> GltfGeometries::read_draco(const GltfPrimitive& primitive,
                                                const std::string& name, const GltfRoom& room) {
  const GltfAccessor& accessor = document_.accessors[*primitive.position];
  const auto key =
      std::tuple(primitive.draco->view, primitive.draco->position_id, accessor.normalized);
  auto& soup = draco_[key];
  if (soup == nullptr) {
    const auto bytes = buffers_.view(primitive.draco->view);
    if (!bytes) return fail(bytes.error());
    auto decoded =
        decode_draco(*bytes, {room.max_vertices - room.vertices, room.max_faces - room.faces},
                     DracoAttribute{primitive.draco->position_id, accessor.normalized});
    if (!decoded) return fail(std::move(decoded.error()));
    soup = std::make_shared<const TriangleSoup>(std::move(*decoded));
  }
  if (soup->positions.size() != accessor.count) {
    findings_.add("draco_count_differs", name,
                  "has another number of vertices than its accessor says");
  }
  GltfGeometry geometry;
  geometry.vertices = soup->positions.size();
  geometry.faces = draws_triangles(primitive) ? soup->faces.size() : 0;
  geometry.draco = soup;
  return geometry;
}

}  // namespace geodesic::proto
