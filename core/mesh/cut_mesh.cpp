#include "core/mesh/cut_mesh.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/base/polled_fill.h"
#include "core/mesh/triangle_soup.h"

namespace geodesic {
namespace {

// What is left, as a file of its own would have it.
struct Piece {
  TriangleSoup soup;
  std::vector<std::uint32_t> vertices;  // of the whole, by the soup's vertex
  std::vector<std::uint32_t> faces;     // source faces of the whole, by the soup's face
};

// Vertices in the order of their first source vertices and faces in that of the file, so that ties
// are broken as in a file of their own. Of no use if the poll says to stop.
Piece piece_of(const Mesh& whole, std::span<const std::uint8_t> is_left, Poll& poll) {
  Piece piece;
  std::uint64_t count = 0;
  std::vector<std::uint32_t> number;  // of the soup, by the whole's vertex
  polled_assign(number, whole.vertex_count(), kNone, poll);
  if (poll.stopped()) return piece;
  std::uint32_t vertex_count = 0;
  for (std::uint32_t source = 0; source < whole.source_face_count(); ++source) {
    if (poll.cancelled()) return piece;
    const std::uint32_t face = whole.face_of_source(source);
    if (face == kNone || is_left[source] == 0) continue;
    ++count;
    for (const std::uint32_t v : whole.faces()[face]) {
      if (number[v] != kNone) continue;
      number[v] = 0;
      ++vertex_count;
    }
  }
  polled_assign(piece.vertices, vertex_count, kNone, poll);
  polled_assign(piece.soup.positions, vertex_count, Vec3{}, poll);
  polled_assign(piece.faces, count, kNone, poll);
  polled_assign(piece.soup.faces, count, Triangle{}, poll);
  if (poll.stopped()) return piece;
  std::uint32_t next = 0;
  for (std::uint32_t source = 0; source < whole.source_vertex_count(); ++source) {
    if (poll.cancelled()) return piece;
    const std::uint32_t v = whole.vertex_of_source()[source];
    if (v == kNone || number[v] == kNone || whole.source_of_vertex(v) != source) continue;
    number[v] = next;
    piece.vertices[next] = v;
    piece.soup.positions[next] = whole.positions()[v];
    ++next;
  }
  std::size_t place = 0;
  for (std::uint32_t source = 0; source < whole.source_face_count(); ++source) {
    if (poll.cancelled()) return piece;
    const std::uint32_t face = whole.face_of_source(source);
    if (face == kNone || is_left[source] == 0) continue;
    const Triangle& corners = whole.faces()[face];
    piece.faces[place] = source;
    piece.soup.faces[place] = {number[corners[0]], number[corners[1]], number[corners[2]]};
    ++place;
  }
  return piece;
}

// The maps of the piece's mesh, in the numbers of the whole's file. Of no use if the poll says to
// stop.
Mesh::Parts in_numbers_of(const Mesh& whole, const Mesh& cut, const Piece& piece,
                          std::span<const std::uint8_t> is_left, Poll& poll) {
  std::vector<std::uint32_t> vertex_of_whole;
  std::vector<std::uint32_t> vertex_of_source;
  std::vector<std::uint32_t> source_of_vertex;
  std::vector<std::uint32_t> face_of_source;
  std::vector<std::uint32_t> source_of_face;
  std::vector<Mesh::DroppedFace> dropped;
  polled_assign(vertex_of_whole, whole.vertex_count(), kNone, poll);
  polled_assign(vertex_of_source, whole.source_vertex_count(), kNone, poll);
  polled_assign(source_of_vertex, cut.vertex_count(), kNone, poll);
  polled_assign(face_of_source, whole.source_face_count(), kNone, poll);
  polled_assign(source_of_face, cut.face_count(), kNone, poll);
  if (poll.stopped() || !poll.may_take(whole.dropped_face_count() * sizeof(Mesh::DroppedFace))) {
    return cut.parts();
  }
  for (std::uint32_t i = 0; i < piece.vertices.size() && !poll.cancelled(); ++i) {
    const std::uint32_t v = cut.vertex_of_source()[i];
    vertex_of_whole[piece.vertices[i]] = v;
    source_of_vertex[v] = whole.source_of_vertex(piece.vertices[i]);
  }
  for (std::uint32_t s = 0; s < vertex_of_source.size() && !poll.cancelled(); ++s) {
    const std::uint32_t v = whole.vertex_of_source()[s];
    if (v != kNone) vertex_of_source[s] = vertex_of_whole[v];
  }
  for (std::uint32_t i = 0; i < piece.faces.size() && !poll.cancelled(); ++i) {
    const std::uint32_t f = cut.face_of_source(i);
    face_of_source[piece.faces[i]] = f;
    source_of_face[f] = piece.faces[i];
  }
  for (Mesh::DroppedFace face : whole.dropped_faces()) {
    if (poll.cancelled()) break;
    if (is_left[face.source_face] == 0) continue;
    for (std::uint32_t& v : face.vertices) v = vertex_of_whole[v];
    // One that touches nothing that is left has no place there.
    if (std::find(face.vertices.begin(), face.vertices.end(), kNone) == face.vertices.end()) {
      dropped.push_back(face);
    }
  }
  Mesh::Parts parts = cut.parts();
  parts.vertex_of_source = SharedArray(std::move(vertex_of_source));
  parts.source_of_vertex = SharedArray(std::move(source_of_vertex));
  parts.face_of_source = SharedArray(std::move(face_of_source));
  parts.source_of_face = SharedArray(std::move(source_of_face));
  parts.dropped = SharedArray(std::move(dropped));
  return parts;
}

}  // namespace

Result<Mesh> cut_mesh(const Mesh& whole, std::span<const std::uint8_t> is_left,
                      const Cancel& cancel) {
  Poll poll(cancel);
  const Piece piece = piece_of(whole, is_left, poll);
  if (poll.ask()) return fail_stopped(poll);
  if (piece.faces.empty()) return fail(ErrorCode::no_triangles, "no face is left");
  // What the whole joins is joined already.
  const auto cut = Mesh::build(piece.soup, Weld::off, cancel);
  if (!cut) return fail(cut.error());
  Mesh::Parts parts = in_numbers_of(whole, *cut, piece, is_left, poll);
  if (poll.ask()) return fail_stopped(poll);
  return Mesh(std::move(parts));
}

}  // namespace geodesic
