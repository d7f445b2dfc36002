#include "server/query/path_points.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace geodesic::server {
namespace {

using Weights = std::array<double, 3>;

// The point's weights in a face; nothing if it is not seen to be in it.
std::optional<Weights> weights_in(const Adjacency& adjacency, std::uint32_t face,
                                  const SurfacePoint& point) {
  if (face == kNone) return std::nullopt;
  if (point.face == face && !point.at_vertex()) return point.bary;
  const auto& corners = adjacency.face(face).vertex;
  Weights weights{0, 0, 0};
  const auto put = [&](std::uint32_t vertex, double weight) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      if (corners[c] == vertex) return weights[c] = weight, true;
    }
    return false;
  };
  if (point.at_vertex()) return put(point.vertex, 1) ? std::optional(weights) : std::nullopt;
  for (std::uint32_t c = 0; c < 3; ++c) {
    if (point.bary[c] == 0) continue;
    if (!put(adjacency.face(point.face).vertex[c], point.bary[c])) return std::nullopt;
  }
  return weights;
}

// The face of the segment from `from`, in whose face it is, to `to`.
std::uint32_t face_of_segment(const Adjacency& adjacency, const SurfacePoint& from,
                              const SurfacePoint& to) {
  const auto begin = weights_in(adjacency, from.face, from);
  const auto end = weights_in(adjacency, from.face, to);
  if (!begin || !end) return from.face;
  for (std::uint32_t c = 0; c < 3; ++c) {
    if ((*begin)[c] != 0 || (*end)[c] != 0) continue;
    // Along the edge across from this corner. Its faces are bounded by the mesh, and a path goes
    // along an edge once.
    const Halfedge edge = halfedge(from.face, next_corner(c));
    std::uint32_t least = from.face;
    for (Halfedge h = adjacency.ring(edge); h != edge; h = adjacency.ring(h)) {
      const Mesh& mesh = adjacency.mesh();
      if (mesh.source_of_face(face_of(h)) < mesh.source_of_face(least)) least = face_of(h);
    }
    return least;
  }
  return from.face;
}

proto::PathReplyPoint reply_of(const Adjacency& adjacency, const Refinement* refinement,
                               const PathPoint& point, std::uint32_t face) {
  proto::PathReplyPoint reply{point.position, std::nullopt, point.point.bary};
  if (face == kNone) return reply;
  const auto weights = weights_in(adjacency, face, point.point);
  const std::uint32_t told = weights ? face : point.point.face;
  reply.face = adjacency.mesh().source_of_face(told);
  if (weights) reply.bary = *weights;
  if (refinement != nullptr) {
    reply.bary = refinement->in_parent(told, reply.bary).value_or(reply.bary);
  }
  return reply;
}

}  // namespace

std::vector<proto::PathReplyPoint> path_points(const Adjacency& adjacency,
                                               const Refinement* refinement, const Path& path) {
  std::vector<proto::PathReplyPoint> replies;
  replies.reserve(path.points.size());
  std::uint32_t face = kNone;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const SurfacePoint& point = path.points[i].point;
    if (i + 1 < path.points.size() && point.face != kNone) {
      face = face_of_segment(adjacency, point, path.points[i + 1].point);
    } else if (i == 0 || !weights_in(adjacency, face, point)) {
      face = point.face;
    }
    replies.push_back(reply_of(adjacency, refinement, path.points[i], face));
  }
  return replies;
}

}  // namespace geodesic::server
