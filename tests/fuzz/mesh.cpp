// Building and welding: what a mesh says of its source holds.
#include "core/mesh/mesh.h"

#include <cmath>
#include <memory>
#include <utility>

#include "core/surface/adjacency.h"
#include "tests/fuzz/small_soup.h"

namespace geodesic::fuzz {

void fuzz_mesh(Input input) {
  Reader reader(input);
  const TriangleSoup soup = small_soup(reader);
  auto built = Mesh::build(soup);
  if (!built) {
    expect(built.error().code == ErrorCode::mesh_invalid, "no face with three corners");
    return;
  }
  const auto mesh = std::make_shared<const Mesh>(std::move(*built));
  expect(mesh->source_vertex_count() == soup.positions.size(), "every source vertex is known");
  for (std::uint32_t s = 0; s < soup.positions.size(); ++s) {
    const std::uint32_t v = mesh->vertex_of_source()[s];
    expect(v < mesh->vertex_count(), "a source vertex has a vertex");
    expect(mesh->positions()[v] == soup.positions[s], "which is where it was");
    expect(mesh->source_of_vertex(v) <= s, "and whose first source vertex is no later one");
    for (std::uint32_t other = 0; other < s; ++other) {
      expect((mesh->vertex_of_source()[other] == v) == (soup.positions[other] == soup.positions[s]),
             "those at one position are one");
    }
  }
  std::uint32_t kept = 0;
  for (std::uint32_t s = 0; s < soup.faces.size(); ++s) {
    const std::uint32_t f = mesh->face_of_source(s);
    if (f == kNone) continue;
    ++kept;
    expect(mesh->source_of_face(f) == s, "a face knows its source");
    for (std::size_t c = 0; c < 3; ++c) {
      expect(mesh->faces()[f][c] == mesh->vertex_of_source()[soup.faces[s][c]],
             "a face keeps its corners in order");
    }
  }
  expect(kept == mesh->face_count(), "every face has a source");
  expect(kept + mesh->dropped_face_count() == soup.faces.size(), "no face is lost");

  const Adjacency adjacency = Adjacency::build(mesh);
  std::uint64_t halfedges_on_boundary = 0;
  for (std::uint32_t f = 0; f < mesh->face_count(); ++f) {
    const FaceRecord& face = adjacency.face(f);
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      std::size_t around = 1;
      for (Halfedge next = adjacency.ring(h); next != h; next = adjacency.ring(next)) {
        const FaceRecord& other = adjacency.face(face_of(next));
        const std::uint32_t from = other.vertex[corner_of(next)];
        const std::uint32_t to = other.vertex[next_corner(corner_of(next))];
        const std::uint32_t a = face.vertex[c];
        const std::uint32_t b = face.vertex[next_corner(c)];
        expect((from == a && to == b) || (from == b && to == a), "a ring is of one edge");
        expect(++around <= 3 * std::size_t{mesh->face_count()}, "a ring comes to its end");
      }
      if (around == 1) ++halfedges_on_boundary;
      const double length2 = face.length2(c);
      const Vec3 edge =
          mesh->positions()[face.vertex[c]] - mesh->positions()[face.vertex[next_corner(c)]];
      // It is the sum of two products, which may be as large as the longest edge's.
      const double most = face.length2(face.longest_side());
      expect(std::abs(length2 - dot(edge, edge)) <= 1e-12 * most, "an edge is as long");
    }
  }
  expect(halfedges_on_boundary == adjacency.report().edges_boundary, "boundary edges are counted");
  expect(adjacency.report().components >= 1, "there is something");
}

}  // namespace geodesic::fuzz
