#include "proto/encode/encode_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "proto/encode/glb_drawing.h"
#include "proto/wire/array_formats.h"

namespace geodesic::proto {
namespace {

std::vector<Vec3> positions_of(const Mesh& mesh, Poll& poll) {
  std::vector<Vec3> positions;
  positions.reserve(mesh.source_vertex_count());
  for (const std::uint32_t v : mesh.vertex_of_source()) {
    if (poll.cancelled()) break;
    positions.push_back(mesh.positions()[v]);
  }
  return positions;
}

// Three source vertices a face.
std::vector<std::uint32_t> triangles_of(const Mesh& mesh, Poll& poll) {
  std::vector<std::uint32_t> triangles;
  triangles.reserve(std::size_t{3} * mesh.source_face_count());
  for (std::uint32_t source = 0; source < mesh.source_face_count(); ++source) {
    if (poll.cancelled()) break;
    const std::uint32_t face = mesh.face_of_source(source);
    const Triangle vertices = face == kNone ? mesh.dropped_face(source) : mesh.faces()[face];
    for (const std::uint32_t v : vertices) triangles.push_back(mesh.source_of_vertex(v));
  }
  return triangles;
}

bool fits_float32(const Box& box) {
  constexpr double kMost = std::numeric_limits<float>::max();
  const Vec3& a = box.min;
  const Vec3& b = box.max;
  return std::min({a.x, a.y, a.z}) >= -kMost && std::max({b.x, b.y, b.z}) <= kMost;
}

}  // namespace

std::uint64_t memory_of_geometry(const Mesh& mesh) {
  return std::uint64_t{72} * mesh.source_vertex_count() +
         std::uint64_t{36} * mesh.source_face_count() + 4096;
}

Result<std::string> geometry_glb(const Mesh& mesh, Poll& poll) {
  if (!fits_float32(mesh.box())) {
    return fail(ErrorCode::unsupported,
                "a GLB holds numbers of float32, which these positions exceed; a frame has them",
                "format");
  }
  // What is not positions and indices is far below a megabyte.
  constexpr std::uint64_t kMostBytes = std::numeric_limits<std::uint32_t>::max() - (1U << 20U);
  const std::uint64_t bytes =
      std::uint64_t{12} * mesh.source_vertex_count() + std::uint64_t{12} * mesh.source_face_count();
  if (bytes > kMostBytes) {
    return fail(ErrorCode::unsupported, "a GLB is below 4 GiB; a frame has any size", "format");
  }
  const GlbPart part{"geometry",
                     GlbPart::Mode::triangles,
                     positions_of(mesh, poll),
                     triangles_of(mesh, poll),
                     {},
                     {},
                     {}};
  const std::vector<std::byte> glb = encode_glb_parts(std::span(&part, 1), &poll);
  if (poll.stopped()) return fail_stopped(poll);
  return std::string(reinterpret_cast<const char*>(glb.data()), glb.size());
}

Result<std::string> geometry_frame(std::string_view id, const Mesh& mesh, Poll& poll) {
  std::vector<double> coordinates;
  coordinates.reserve(std::size_t{3} * mesh.source_vertex_count());
  for (const std::uint32_t v : mesh.vertex_of_source()) {
    if (poll.cancelled()) break;
    const Vec3 p = mesh.positions()[v];
    coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
  }
  const std::uint64_t vertices = mesh.source_vertex_count();
  const std::uint64_t faces = mesh.source_face_count();
  std::vector<Array> arrays(2);
  arrays[0] = {"positions", NumberType::f64, {vertices, 3}, f64_bytes(coordinates, &poll)};
  arrays[1] = {
      "triangles", NumberType::u32, {faces, 3}, u32_bytes(triangles_of(mesh, poll), &poll)};
  if (poll.stopped()) return fail_stopped(poll);
  return frame({{"mesh", id}, {"vertices", vertices}, {"faces", faces}}, arrays);
}

}  // namespace geodesic::proto
