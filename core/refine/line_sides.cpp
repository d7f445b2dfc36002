#include "core/refine/line_sides.h"

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/refine/faces_inside.h"
#include "core/surface/refined_surface.h"

namespace geodesic {
namespace {

// 0, 1, 2 …
SharedArray<std::uint32_t> own_numbers(std::uint32_t count, Poll& poll) {
  std::vector<std::uint32_t> numbers;
  polled_assign(numbers, count, std::uint32_t{0}, poll);
  for (std::uint32_t i = 0; i < numbers.size() && !poll.cancelled(); ++i) numbers[i] = i;
  return SharedArray(std::move(numbers));
}

// The same surface as if it were a file's: whatever was split and cut before, each of its vertices
// and faces is a source vertex and a source face.
Adjacency in_own_numbers(const Adjacency& surface, Poll& poll) {
  Mesh::Parts parts = surface.mesh().parts();
  parts.vertex_of_source = own_numbers(surface.mesh().vertex_count(), poll);
  parts.source_of_vertex = parts.vertex_of_source;
  parts.face_of_source = own_numbers(surface.mesh().face_count(), poll);
  parts.source_of_face = parts.face_of_source;
  parts.dropped = {};
  return {std::make_shared<const Mesh>(std::move(parts)), surface.parts()};
}

}  // namespace

Result<LineSides> LineSides::find(const Adjacency& surface, const SurfacePolyline& line,
                                  std::uint64_t most_vertices, const Cancel& cancel) {
  Poll poll(cancel);
  const Adjacency own = in_own_numbers(surface, poll);
  if (poll.stopped()) return fail_stopped(poll);
  auto refined = refine_along(own, std::span(&line, 1), most_vertices, cancel);
  if (!refined) return fail(std::move(refined.error()));
  const auto mesh = std::make_shared<const Mesh>(std::move(refined->mesh));
  const auto adjacency = build_unrefined(mesh, cancel);
  if (!adjacency) return fail(adjacency.error());
  const std::vector<std::uint32_t>& chain = refined->chains.front();
  auto inside = faces_inside(*adjacency, chain, cancel);
  if (!inside) return fail(std::move(inside.error()));

  LineSides sides;
  std::vector<std::uint8_t> vertices;  // of the refined mesh
  polled_assign(vertices, mesh->vertex_count(), std::uint8_t{0}, poll);
  polled_assign(sides.vertices_, surface.mesh().vertex_count(), std::uint8_t{0}, poll);
  polled_assign(sides.whole_faces_, surface.mesh().face_count(), std::uint8_t{0}, poll);
  if (poll.stopped()) return fail_stopped(poll);
  for (std::uint32_t f = 0; f < mesh->face_count() && !poll.cancelled(); ++f) {
    if ((*inside)[f] == 0) continue;
    sides.whole_faces_[mesh->source_of_face(f)] = 1;
    for (const std::uint32_t v : mesh->faces()[f]) vertices[v] = 1;
  }
  for (const std::uint32_t v : chain) vertices[v] = 0;
  for (std::uint32_t v = 0; v < sides.vertices_.size() && !poll.cancelled(); ++v) {
    const std::uint32_t there = mesh->vertex_of_source()[v];
    if (there != kNone) sides.vertices_[v] = vertices[there];
  }
  if (poll.ask()) return fail_stopped(poll);
  sides.pieces_ = std::move(*inside);
  sides.refinement_ = std::move(refined->refinement);
  return sides;
}

bool LineSides::is_inside(const SurfacePoint& point, Poll& poll) const {
  if (point.at_vertex()) return is_inside(point.vertex);
  const auto piece = refinement_.in_piece(point.face, point.bary, poll);
  return (piece ? pieces_[piece->face] : whole_faces_[point.face]) != 0;
}

}  // namespace geodesic
