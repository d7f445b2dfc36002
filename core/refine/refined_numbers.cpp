#include "core/refine/refined_numbers.h"

#include <algorithm>
#include <utility>

#include "core/base/polled_fill.h"

namespace geodesic {

bool RefinedSoup::reserve(std::size_t vertices, std::size_t faces, Poll& poll) {
  if (!poll.may_take(vertices * (sizeof(Vec3) + sizeof(std::uint32_t)) +
                     faces * (sizeof(Triangle) + sizeof(std::uint32_t)))) {
    return false;
  }
  soup_.positions.reserve(vertices);
  sources_.reserve(vertices);
  soup_.faces.reserve(faces);
  parents_.reserve(faces);
  return true;
}

Result<RefinedSoup::Built> RefinedSoup::build(const Mesh& whole, const Cancel& cancel) const {
  Poll poll(cancel);
  // What the whole joins is joined already.
  auto built = Mesh::build(soup_, Weld::off, cancel);
  if (!built) {
    if (built.error().code == ErrorCode::mesh_invalid) {
      return fail(ErrorCode::no_triangles, "the lines leave no part of a face with a surface");
    }
    return fail(std::move(built.error()));
  }
  std::vector<std::uint32_t> vertex_of_source;
  std::vector<std::uint32_t> source_of_vertex;
  std::vector<std::uint32_t> face_of_source;
  std::vector<std::uint32_t> source_of_face;
  std::vector<std::uint32_t> vertex_of_whole;
  polled_assign(vertex_of_source, whole.source_vertex_count(), kNone, poll);
  polled_assign(source_of_vertex, built->vertex_count(), kNone, poll);
  polled_assign(face_of_source, whole.source_face_count(), kNone, poll);
  polled_assign(source_of_face, built->face_count(), kNone, poll);
  polled_assign(vertex_of_whole, whole.vertex_count(), kNone, poll);
  if (poll.stopped() || !poll.may_take(whole.dropped_face_count() * sizeof(Mesh::DroppedFace))) {
    return fail_stopped(poll);
  }
  for (std::uint32_t i = 0; i < sources_.size() && !poll.cancelled(); ++i) {
    const std::uint32_t v = built->vertex_of_source()[i];
    if (source_of_vertex[v] == kNone) source_of_vertex[v] = sources_[i];
    if (sources_[i] >= whole.source_vertex_count()) continue;
    std::uint32_t& there = vertex_of_whole[whole.vertex_of_source()[sources_[i]]];
    if (there == kNone) there = v;
  }
  for (std::uint32_t s = 0; s < vertex_of_source.size() && !poll.cancelled(); ++s) {
    const std::uint32_t v = whole.vertex_of_source()[s];
    if (v != kNone) vertex_of_source[s] = vertex_of_whole[v];
  }
  for (std::uint32_t i = 0; i < parents_.size() && !poll.cancelled(); ++i) {
    const std::uint32_t f = built->face_of_source(i);
    if (f == kNone) continue;
    source_of_face[f] = parents_[i];
    if (face_of_source[parents_[i]] == kNone) face_of_source[parents_[i]] = f;
  }
  std::vector<FacePiece> pieces;
  for (FacePiece piece : pieces_) {
    if (poll.cancelled()) break;
    piece.face = built->face_of_source(piece.face);
    if (piece.face != kNone) pieces.push_back(piece);
  }
  std::vector<Mesh::DroppedFace> dropped;
  for (Mesh::DroppedFace face : whole.dropped_faces()) {
    if (poll.cancelled()) break;
    for (std::uint32_t& v : face.vertices) v = vertex_of_whole[v];
    // One that touches nothing that is left has no place there.
    if (std::find(face.vertices.begin(), face.vertices.end(), kNone) == face.vertices.end()) {
      dropped.push_back(face);
    }
  }
  if (poll.ask()) return fail_stopped(poll);
  Built result{std::move(*built), Refinement(std::move(pieces)), {}};
  const auto vertices = result.mesh.vertex_of_source();
  result.vertex_of_soup.assign(vertices.begin(), vertices.end());
  Mesh::Parts parts = result.mesh.parts();
  parts.vertex_of_source = SharedArray(std::move(vertex_of_source));
  parts.source_of_vertex = SharedArray(std::move(source_of_vertex));
  parts.face_of_source = SharedArray(std::move(face_of_source));
  parts.source_of_face = SharedArray(std::move(source_of_face));
  parts.dropped = SharedArray(std::move(dropped));
  result.mesh = Mesh(std::move(parts));
  return result;
}

}  // namespace geodesic
