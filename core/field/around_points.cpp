#include "core/field/around_points.h"

#include <algorithm>
#include <optional>
#include <unordered_set>

#include "core/base/edge_key.h"

namespace geodesic {
namespace {

// The ends of the edge that a point lies on, if it is not at a vertex; none inside a face.
std::optional<std::uint64_t> edge_of(const Adjacency& adjacency, const SurfacePoint& point) {
  const FaceRecord& face = adjacency.face(point.face);
  for (std::uint32_t c = 0; c < 3; ++c) {
    if (point.bary[c] != 0) continue;
    return edge_key(face.vertex[next_corner(c)], face.vertex[previous_corner(c)]);
  }
  return std::nullopt;
}

void make_set(std::vector<std::uint32_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

Result<std::vector<std::uint32_t>> faces_around(const Adjacency& adjacency,
                                                std::span<const SurfacePoint> points,
                                                const Cancel& cancel) {
  std::vector<std::uint32_t> faces;
  std::unordered_set<std::uint64_t> edges;
  Poll poll(cancel);
  for (const SurfacePoint& point : points) {
    if (poll.cancelled()) return fail_stopped(cancel);
    if (point.at_vertex()) continue;
    const auto edge = edge_of(adjacency, point);
    if (edge && !edges.insert(*edge).second) continue;
    for (const SurfacePoint& place : in_all_faces(adjacency, point)) {
      if (poll.cancelled()) return fail_stopped(cancel);
      faces.push_back(place.face);
    }
  }
  make_set(faces);
  return faces;
}

Result<std::vector<std::uint32_t>> vertices_around(const Adjacency& adjacency,
                                                   std::span<const SurfacePoint> points,
                                                   const Cancel& cancel) {
  const auto faces = faces_around(adjacency, points, cancel);
  if (!faces) return fail(faces.error());
  std::vector<std::uint32_t> vertices;
  Poll poll(cancel);
  for (const std::uint32_t f : *faces) {
    if (poll.cancelled()) return fail_stopped(cancel);
    for (const std::uint32_t v : adjacency.face(f).vertex) vertices.push_back(v);
  }
  for (const SurfacePoint& point : points) {
    if (point.at_vertex()) vertices.push_back(point.vertex);
  }
  make_set(vertices);
  return vertices;
}

}  // namespace geodesic
