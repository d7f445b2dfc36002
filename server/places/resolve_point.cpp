#include "server/places/resolve_point.h"

#include <cmath>
#include <string>
#include <utility>

#include "server/base/service_codes.h"

namespace geodesic::server {
namespace {

std::optional<std::uint64_t> source_face(const Mesh& mesh, std::uint32_t face) {
  if (face == kNone) return std::nullopt;
  return mesh.source_of_face(face);
}

// A surface, and what its faces are parts of.
struct Split {
  const Adjacency& adjacency;
  const Refinement* refinement;

  [[nodiscard]] const Mesh& mesh() const { return adjacency.mesh(); }
  [[nodiscard]] PlacedPoint placed(const SurfacePoint& point) const {
    return {point, reply_point(mesh(), refinement, point)};
  }
};

Result<PlacedPoint> at_vertex(const Split& surface, std::uint64_t vertex,
                              const std::string& parameter) {
  const Mesh& mesh = surface.mesh();
  if (vertex >= mesh.source_vertex_count()) {
    return fail_limit(ErrorCode::index_out_of_range, "the mesh has no such vertex",
                      mesh.source_vertex_count() - 1, vertex, parameter);
  }
  const std::uint32_t there = mesh.vertex_of_source()[vertex];
  if (there == kNone) {
    return fail(ServiceCode::outside_region,
                "no face at this vertex is left: it is forbidden, or not within", parameter);
  }
  PlacedPoint result = surface.placed(point_at_vertex(surface.adjacency, there));
  result.echo.vertex = vertex;  // the one that was asked for, of those welded together
  return result;
}

// A face that welding left with two equal corners has become an edge: its points
// are those of the edge.
Result<PlacedPoint> on_dropped_face(const Split& surface, std::uint32_t face,
                                    const std::array<double, 3>& bary,
                                    const std::string& parameter) {
  const Adjacency& adjacency = surface.adjacency;
  const Mesh& mesh = surface.mesh();
  const Triangle t = mesh.dropped_face(face);
  double at_first = 0;  // the weight of all corners that are t[0]
  std::uint32_t other = t[0];
  for (std::size_t c = 0; c < 3; ++c) {
    if (t[c] == t[0]) {
      at_first += bary[c];
    } else {
      other = t[c];
    }
  }
  if (other == t[0]) return surface.placed(point_at_vertex(adjacency, t[0]));
  const Halfedge h = adjacency.find_edge(t[0], other);
  if (h == kNone) {
    return fail(ErrorCode::mesh_invalid, "this face has no surface and touches no other face",
                parameter);
  }
  const std::uint32_t c = corner_of(h);
  const bool forward = adjacency.face(face_of(h)).vertex[c] == t[0];
  std::array<double, 3> weights{0, 0, 0};
  weights[forward ? c : next_corner(c)] = at_first;
  weights[forward ? next_corner(c) : c] = 1 - at_first;
  return surface.placed(snapped_point(adjacency, face_of(h), weights));
}

tl::unexpected<Error> not_left(const std::string& parameter) {
  return fail(ServiceCode::outside_region,
              "this face is not on the part of the surface that is left", parameter);
}

Result<PlacedPoint> on_face(const Split& surface, const proto::FaceRequest& request,
                            const std::string& parameter, const Cancel& cancel) {
  const Mesh& mesh = surface.mesh();
  if (request.face >= mesh.source_face_count()) {
    return fail_limit(ErrorCode::index_out_of_range, "the mesh has no such face",
                      mesh.source_face_count() - 1, request.face, parameter);
  }
  const auto source = static_cast<std::uint32_t>(request.face);
  const std::uint32_t face = mesh.face_of_source(source);
  if (face == kNone && !mesh.is_dropped(source)) {
    return not_left(parameter);
  }
  if (face == kNone) return on_dropped_face(surface, source, request.bary, parameter);
  if (surface.refinement == nullptr || !surface.refinement->is_split(source)) {
    return surface.placed(snapped_point(surface.adjacency, face, request.bary));
  }
  Poll poll(cancel);
  const auto part = surface.refinement->in_piece(source, request.bary, poll);
  if (poll.stopped()) return fail_stopped(poll);
  if (!part) return not_left(parameter);
  return surface.placed(snapped_point(surface.adjacency, part->face, part->bary));
}

Result<void> check_coordinates(Vec3 point, const std::string& parameter) {
  for (const double coordinate : {point.x, point.y, point.z}) {
    if (std::abs(coordinate) > Mesh::kMaxCoordinate) {
      return fail(ErrorCode::value_out_of_range, "a coordinate is too large", parameter);
    }
  }
  return {};
}

Result<PlacedPoint> closest_to(const Split& surface, const ClosestPointIndex& index,
                               const proto::SpaceRequest& request, const std::string& parameter,
                               const Cancel& cancel) {
  if (auto usable = check_coordinates(request.xyz, parameter); !usable) return fail(usable.error());
  const auto found = index.closest(request.xyz, cancel);
  if (!found) return fail(found.error());
  if (request.max_snap && found->distance > *request.max_snap) {
    return fail(ServiceCode::snap_too_far,
                "the surface is " + std::to_string(found->distance) + " away", parameter);
  }
  PlacedPoint result = surface.placed(found->point);
  result.echo.snap_distance = found->distance;
  return result;
}

Result<PlacedPoint> first_on_ray(const Split& surface, const ClosestPointIndex& index,
                                 const proto::RayRequest& request, const std::string& parameter,
                                 const Cancel& cancel) {
  if (auto usable = check_coordinates(request.origin, parameter); !usable) {
    return fail(usable.error());
  }
  const auto hit = index.first_hit(request.origin, request.direction, cancel);
  if (!hit) return fail(hit.error());
  if (!*hit)
    return fail(ErrorCode::no_hit, "the ray does not meet the surface, or what regions leave of it",
                parameter);
  PlacedPoint result = surface.placed((*hit)->point);
  result.echo.ray_distance = (*hit)->distance;
  return result;
}

}  // namespace

bool is_searched(const proto::PointRequest& request) {
  return std::holds_alternative<proto::SpaceRequest>(request.where) ||
         std::holds_alternative<proto::RayRequest>(request.where);
}

bool is_on_dropped_face(const Mesh& mesh, const proto::PointRequest& request) {
  const auto* asked = std::get_if<proto::FaceRequest>(&request.where);
  return asked != nullptr && asked->face < mesh.source_face_count() &&
         mesh.is_dropped(static_cast<std::uint32_t>(asked->face));
}

bool is_on_split_face(const Refinement* refinement, const proto::PointRequest& request) {
  const auto* asked = std::get_if<proto::FaceRequest>(&request.where);
  return refinement != nullptr && asked != nullptr && asked->face < kNone &&
         refinement->is_split(static_cast<std::uint32_t>(asked->face));
}

Result<PlacedPoint> resolve_point(const Adjacency& adjacency, const Refinement* refinement,
                                  const ClosestPointIndex* index,
                                  const proto::PointRequest& request, const Cancel& cancel) {
  const Split surface{adjacency, refinement};
  if (const auto* vertex = std::get_if<proto::VertexRequest>(&request.where)) {
    return at_vertex(surface, vertex->vertex, request.parameter);
  }
  if (const auto* face = std::get_if<proto::FaceRequest>(&request.where)) {
    return on_face(surface, *face, request.parameter, cancel);
  }
  if (const auto* ray = std::get_if<proto::RayRequest>(&request.where)) {
    return first_on_ray(surface, *index, *ray, request.parameter, cancel);
  }
  return closest_to(surface, *index, std::get<proto::SpaceRequest>(request.where),
                    request.parameter, cancel);
}

proto::ResolvedPoint reply_point(const Mesh& mesh, const Refinement* refinement,
                                 const SurfacePoint& point) {
  proto::ResolvedPoint reply;
  reply.face = source_face(mesh, point.face);
  reply.bary = point.bary;
  if (refinement != nullptr && point.face != kNone) {
    reply.bary = refinement->in_parent(point.face, point.bary).value_or(point.bary);
  }
  reply.xyz = position_of(mesh, point);
  // One that a line has made has no number in the file.
  if (point.at_vertex() && mesh.source_of_vertex(point.vertex) < mesh.source_vertex_count()) {
    reply.vertex = mesh.source_of_vertex(point.vertex);
  }
  return reply;
}

}  // namespace geodesic::server
