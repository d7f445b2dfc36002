// Bytes of a file, to a prepared mesh.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <utility>

#include "core/mesh/mesh.h"
#include "core/surface/adjacency.h"
#include "proto/draco/codec.h"
#include "proto/formats/decode_mesh.h"
#include "proto/gltf/annotate.h"
#include "proto/gltf/weights.h"
#include "proto/gltf_file/container.h"
#include "proto/gltf_file/parse.h"
#include "proto/mesh/metadata.h"
#include "tests/fuzz/targets.h"

namespace geodesic::fuzz {
namespace {

// A glTF file that can be read can be annotated, or there is a reason; and then it can be read
// again.
void check_annotation(std::span<const std::byte> bytes, const proto::DecodeLimits& limits,
                      const proto::DecodedMesh& decoded) {
  if (decoded.format != proto::MeshFormat::glb && decoded.format != proto::MeshFormat::gltf) return;
  const auto annotation =
      proto::annotate_gltf(bytes, limits, {}, {{"_GEODESIC_DISTANCE", 1}, {"_SOURCE", 3}});
  if (!annotation) {
    expect(annotation.error().parameter == "format" || annotation.error().parameter == "attribute",
           "what cannot be annotated has a way out");
    return;
  }
  std::uint64_t next = 0;
  for (const proto::VertexRun& run : annotation->runs) {
    expect(run.first >= next && run.count > 0, "primitives come in the order of vertices");
    next = run.first + run.count;
  }
  expect(next <= decoded.soup.positions.size(), "values are those of the mesh");
  expect(proto::check_json_shape(annotation->json, limits).has_value() &&
             proto::parse_gltf(annotation->json, limits).has_value(),
         "what was annotated can be read");
}

// Each vertex of Draco data has a number of an attribute, or none has.
void check_numbers(std::span<const std::byte> bytes, const proto::DecodeLimits& limits,
                   const proto::DecodedMesh& decoded) {
  if (decoded.format != proto::MeshFormat::drc) return;
  for (std::uint32_t id = 0; id < 3; ++id) {
    const auto numbers = proto::decode_draco_numbers(bytes, {limits.max_vertices, limits.max_faces},
                                                     {id, id % 2 == 1});
    if (numbers) {
      expect(numbers->size() == decoded.soup.positions.size(), "a number for each vertex");
    } else {
      expect(numbers.error().code == ErrorCode::mesh_invalid, "numbers are there or are not");
    }
  }
}

// Each face has a weight, or there is a reason.
void check_weights(std::span<const std::byte> bytes, const proto::DecodeLimits& limits,
                   const proto::DecodedMesh& decoded) {
  if (decoded.format != proto::MeshFormat::glb && decoded.format != proto::MeshFormat::gltf) return;
  const auto weights =
      proto::read_face_numbers(bytes, limits, {}, "_MUD", proto::FaceNumber::weight);
  if (weights) {
    expect(weights->by_face.size() == decoded.soup.faces.size(), "a weight for each face");
    for (const double weight : weights->by_face) {
      expect(weight > 0 && std::isfinite(weight), "weights are above 0");
    }
  } else {
    expect(weights.error().code != ErrorCode::internal && !weights.error().detail.empty(),
           "an error says what is wrong");
  }
}

}  // namespace

void fuzz_decoding(Input input) {
  proto::DecodeLimits limits;
  limits.max_vertices = 20'000;
  limits.max_faces = 20'000;
  limits.max_nodes = 2'000;
  limits.max_gltf_objects = 5'000;
  limits.max_json_values = 50'000;
  auto decoded = proto::decode_mesh(std::as_bytes(input), limits);
  if (!decoded) {
    expect(decoded.error().code != ErrorCode::internal, "an error is the file's, not ours");
    expect(!decoded.error().detail.empty(), "an error says what is wrong");
    return;
  }
  const TriangleSoup& soup = decoded->soup;
  expect(soup.positions.size() <= limits.max_vertices, "no more vertices than allowed");
  expect(!soup.faces.empty() && soup.faces.size() <= limits.max_faces, "faces, within limits");
  for (const auto& part : decoded->parts) {
    expect(part.first_vertex + part.vertex_count <= soup.positions.size() &&
               part.first_face + part.face_count <= soup.faces.size(),
           "parts are within the mesh");
  }
  std::uint64_t next = 0;
  for (const proto::MaterialRun& run : decoded->materials.runs) {
    expect(run.end > next && run.end <= soup.faces.size(), "materials are those of faces");
    next = run.end;
  }
  check_annotation(std::as_bytes(input), limits, *decoded);
  check_numbers(std::as_bytes(input), limits, *decoded);
  check_weights(std::as_bytes(input), limits, *decoded);
  auto mesh = Mesh::build(soup);
  if (!mesh) {
    expect(mesh.error().code == ErrorCode::mesh_invalid, "a decoded mesh is checked");
    return;
  }
  const auto shared = std::make_shared<const Mesh>(std::move(*mesh));
  const Adjacency adjacency = Adjacency::build(shared);
  const std::string description = proto::describe_mesh("id", input.size(), {}, *decoded, adjacency);
  expect(description.starts_with('{'), "a mesh can be described");
  const auto told = proto::parts_in(description);
  expect(told && told->total == decoded->part_count, "what is described can be read");
}

}  // namespace geodesic::fuzz
