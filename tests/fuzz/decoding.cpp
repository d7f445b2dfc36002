// Bytes of a file, to a prepared mesh.
#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <utility>

#include "core/mesh/mesh.h"
#include "core/surface/adjacency.h"
#include "proto/formats/decode_mesh.h"
#include "proto/mesh/metadata.h"
#include "tests/fuzz/targets.h"

namespace geodesic::fuzz {

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
  auto mesh = Mesh::build(soup);
  if (!mesh) {
    expect(mesh.error().code == ErrorCode::mesh_invalid, "a decoded mesh is checked");
    return;
  }
  const auto shared = std::make_shared<const Mesh>(std::move(*mesh));
  const Adjacency adjacency = Adjacency::build(shared);
  const std::string description = proto::describe_mesh("id", input.size(), {}, *decoded, adjacency);
  expect(description.starts_with('{'), "a mesh can be described");
}

}  // namespace geodesic::fuzz
