// Queries for ways over the surface.
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/join_paths.h"
#include "core/shorten_path.h"
#include "core/steiner_path.h"
#include "core/straightest_geodesic.h"
#include "core/trace_path.h"
#include "server/field_queries.h"
#include "server/query_place.h"

namespace geodesic::server {
namespace {

using MaybePath = std::optional<Path>;

// The way from one point to the next; nothing when there is none.
class LegFinder {
 public:
  LegFinder(Fields& fields, const proto::PathRequest& request, const Caller& caller)
      : fields_(fields), request_(request), caller_(caller) {}

  // Whether all the fields asked for were there; nothing when none was asked for.
  [[nodiscard]] std::optional<bool> cache_hit() const { return hit_; }

  Result<MaybePath> find(const FieldQuestion& question, const SurfacePoint& to) {
    return request_.method.which == Method::steiner ? by_refinement(question, to)
                                                    : by_field(question, to);
  }

 private:
  // Back from the end through the field of the start: the whole field, not one that
  // stops at the target. Whoever asks for one path from a source asks for the next
  // one as the mouse moves.
  Result<MaybePath> by_field(const FieldQuestion& question, const SurfacePoint& to) {
    const auto field = fields_.whole(question, caller_);
    if (!field) return fail(field.error());
    hit_ = hit_.value_or(true) && field->hit;
    return fields_.compute(
        [&](SolveScratch&, const Cancel& cancel) {
          return refined(*question.adjacency, trace_path(*question.adjacency, *field->value, to),
                         cancel);
        },
        caller_);
  }

  // By the method's own refinement of a path, which keeps no field.
  Result<MaybePath> by_refinement(const FieldQuestion& question, const SurfacePoint& to) {
    return fields_.compute(
        [&](SolveScratch& scratch, const Cancel& cancel) -> Result<MaybePath> {
          auto path = steiner_path(*question.adjacency, question.sources.front(), to,
                                   request_.method.options, scratch.wavefront, cancel);
          if (!path) return fail(std::move(path.error()));
          return refined(*question.adjacency, std::move(*path), cancel);
        },
        caller_);
  }

  Result<MaybePath> refined(const Adjacency& adjacency, MaybePath path, const Cancel& cancel) {
    if (!path || request_.refine == proto::Refine::none) return path;
    auto shorter = shorten_path(adjacency, *path, cancel);
    if (!shorter) return fail(std::move(shorter.error()));
    return MaybePath(std::move(*shorter));
  }

  Fields& fields_;
  const proto::PathRequest& request_;
  const Caller& caller_;
  std::optional<bool> hit_;
};

std::string_view name_of(StraightestGeodesic::End end) {
  switch (end) {
    case StraightestGeodesic::End::length:
      return "length";
    case StraightestGeodesic::End::boundary:
      return "boundary";
    case StraightestGeodesic::End::vertex:
      return "vertex";
    case StraightestGeodesic::End::non_manifold:
      return "non_manifold";
  }
  return "length";
}

std::vector<proto::PathReplyPoint> reply_points(const Mesh& mesh, const Path& path) {
  std::vector<proto::PathReplyPoint> points;
  points.reserve(path.points.size());
  for (const PathPoint& point : path.points) points.push_back(path_reply_point(mesh, point));
  return points;
}

}  // namespace

Result<Answered<proto::PathReply>> FieldQueries::answer(const std::string& mesh,
                                                        const proto::PathRequest& request,
                                                        const Caller& caller) {
  const auto place = find(mesh, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::PathReply> answer;
  proto::PathReply& reply = answer.reply;
  reply.mesh = mesh;
  reply.method = request.method.which;
  reply.refine = request.refine;
  const auto from = place->point(request.from, reply.from);
  if (!from) return fail(from.error());
  auto stops = place->points(request.via, reply.via);
  if (!stops) return fail(stops.error());
  const auto to = place->point(request.to, reply.to);
  if (!to) return fail(to.error());
  stops->push_back(*to);

  LegFinder finder(fields_, request, caller);
  std::vector<Path> legs;
  SurfacePoint start = *from;
  for (const SurfacePoint& stop : *stops) {
    auto leg = finder.find({mesh, place->adjacency(), request.method, {Source{start, 0}}}, stop);
    if (!leg) return fail(std::move(leg.error()));
    answer.cache_hit = finder.cache_hit();
    if (!*leg) return answer;  // not reachable
    legs.push_back(std::move(**leg));
    start = stop;
  }
  const Path path = join_paths(legs);
  reply.reachable = true;
  reply.length = path.length;
  reply.points = reply_points(place->mesh(), path);
  return answer;
}

Result<Answered<proto::TraceReply>> FieldQueries::answer(const std::string& mesh,
                                                         const proto::TraceRequest& request,
                                                         const Caller& caller) {
  const auto place = find(mesh, caller);
  if (!place) return fail(place.error());
  Answered<proto::TraceReply> answer;
  proto::TraceReply& reply = answer.reply;
  reply.mesh = mesh;
  const auto from = place->point(request.from, reply.from);
  if (!from) return fail(from.error());
  const auto found = fields_.compute(
      [&](SolveScratch&, const Cancel& cancel) {
        const Adjacency& adjacency = *place->adjacency();
        if (const auto* direction = std::get_if<Vec3>(&request.ahead)) {
          return straightest_geodesic(adjacency, *from, *direction, request.length, cancel);
        }
        return straightest_geodesic_at_angle(adjacency, *from, std::get<double>(request.ahead),
                                             request.length, cancel);
      },
      caller);
  if (!found) return fail(found.error());
  reply.length = found->path.length;
  reply.end = name_of(found->end);
  reply.direction_at_end = found->direction_at_end;
  reply.points = reply_points(place->mesh(), found->path);
  reply.to = reply_point(place->mesh(), found->path.points.back().point);
  return answer;
}

}  // namespace geodesic::server
