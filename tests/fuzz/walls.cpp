// Regions with walls and insides on a tiny mesh, cut as the server cuts them: what is left is a
// part of the surface, and no way over it is shorter than over the whole.
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/solve/solve_field.h"
#include "server/places/walled_surface.h"
#include "tests/fuzz/small_soup.h"

namespace geodesic::fuzz {
namespace {

constexpr double kRounding = 1e-7;  // relative
constexpr double kOfSize = 1e-9;

proto::PointRequest point_request(const Mesh& mesh, const SurfacePoint& point) {
  if (point.at_vertex()) {
    return {proto::VertexRequest{mesh.source_of_vertex(point.vertex)}, 0, "walls"};
  }
  // The corners of a source face are those of the face, in the same order.
  return {proto::FaceRequest{mesh.source_of_face(point.face), point.bary}, 0, "walls"};
}

proto::Regions some_regions(const Adjacency& adjacency, Reader& reader) {
  proto::Regions regions;
  const auto points = [&](int count) {
    std::vector<proto::PointRequest> line;
    for (int i = 0; i < count; ++i) {
      line.push_back(point_request(adjacency.mesh(), small_point(adjacency, reader)));
    }
    return line;
  };
  for (int i = reader.byte() % 5; i > 0; --i) {
    const std::uint8_t kind = reader.byte();
    const Vec3 place = position_of(adjacency.mesh(), small_point(adjacency, reader));
    switch (kind % 6) {
      case 0:
        regions.forbid.push_back(
            {std::vector<proto::FaceRange>{{kind / 6U % adjacency.mesh().source_face_count(),
                                            kind / 6U % adjacency.mesh().source_face_count()}},
             "forbid"});
        break;
      case 1:
        regions.forbid.push_back({proto::SphereShape{place, 0.1 * kind}, "forbid"});
        break;
      case 2:
        regions.within.push_back({proto::InsideShape{points(3)}, "within"});
        break;
      case 3:
        regions.forbid.push_back({proto::InsideShape{points(3)}, "forbid"});
        break;
      default:
        regions.walls.push_back({points(2 + kind / 128), "walls"});
        break;
    }
  }
  return regions;
}

Field exact_field(const Adjacency& adjacency, const SurfacePoint& from) {
  SolveScratch scratch;
  const Source source{from, 0};
  auto field = solve_field(Method::exact, {}, adjacency, {&source, 1}, {}, scratch, Cancel());
  expect(field.has_value(), "every mesh has a field");
  return std::move(*field);
}

// Parts of the file's faces, each within its own, and together no larger than the whole.
void check_pieces(const Mesh& whole, const CutMesh& cut, double size) {
  double sum = 0;
  for (std::uint32_t f = 0; f < cut.mesh.face_count(); ++f) {
    expect(cut.mesh.source_of_face(f) < whole.source_face_count(), "a face is part of the file's");
    const auto& t = cut.mesh.faces()[f];
    const auto p = cut.mesh.positions();
    sum += norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])) / 2;
    const FacePiece* piece = cut.refinement.piece(f);
    if (piece == nullptr) continue;
    expect(piece->parent == cut.mesh.source_of_face(f), "a piece knows its face");
    for (const Weights& corner : piece->corners) {
      double all = 0;
      for (const double weight : corner) {
        expect(weight >= -kOfSize && weight <= 1 + kOfSize, "a piece is within its face");
        all += weight;
      }
      expect(std::abs(all - 1) <= kOfSize, "weights add up to one");
    }
  }
  expect(sum <= whole.area() * (1 + kRounding) + kOfSize * size * size, "no face is added");
}

}  // namespace

void fuzz_walls(Input input) {
  Reader reader(input);
  std::vector<std::uint8_t> drawn;
  for (int i = 0; i < 48; ++i) drawn.push_back(reader.byte());
  const auto mesh = small_mesh(reader);
  if (mesh == nullptr) return;
  const Adjacency adjacency = Adjacency::build(mesh);
  const double size = distance(mesh->box().min, mesh->box().max);

  Reader places(drawn);
  const proto::Regions regions = some_regions(adjacency, places);
  auto cut = server::cut_lines(adjacency, nullptr, regions, {}, Cancel());
  if (!cut) {
    const ErrorCode code = cut.error().code;
    expect(code == ErrorCode::value_out_of_range || code == ErrorCode::no_triangles,
           "what cannot be cut is the client's error");
    expect(!cut.error().detail.empty(), "and says why");
    return;
  }
  check_pieces(*mesh, *cut, size);
  const auto left = std::make_shared<const Mesh>(cut->mesh);
  const Adjacency remaining = Adjacency::build(left);
  const std::uint32_t source = left->faces()[0][0];
  const std::uint32_t of_file = left->source_of_vertex(source);
  if (of_file >= mesh->source_vertex_count()) return;  // one that a line has made
  const Field short_ways =
      exact_field(adjacency, point_at_vertex(adjacency, mesh->vertex_of_source()[of_file]));
  const Field ways = exact_field(remaining, point_at_vertex(remaining, source));
  for (std::uint32_t v = 0; v < left->vertex_count(); ++v) {
    const std::uint32_t s = left->source_of_vertex(v);
    if (s >= mesh->source_vertex_count()) continue;
    const double least = short_ways.distance[mesh->vertex_of_source()[s]];
    expect(ways.distance[v] >= least * (1 - kRounding) - kOfSize * size,
           "no way becomes shorter by a wall");
    if (regions.is_everything() && least != kUnreached) {
      expect(ways.distance[v] <= least * (1 + kRounding) + kOfSize * size,
             "nor longer without one");
    }
  }
}

}  // namespace geodesic::fuzz
