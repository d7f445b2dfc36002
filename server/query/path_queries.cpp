// Queries for ways over the surface.
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/paths/join_paths.h"
#include "core/solve/scratch_parts.h"
#include "core/steiner/path.h"
#include "core/straighten/refine_path.h"
#include "core/straighten/shorten_path.h"
#include "core/straighten/straightest_geodesic.h"
#include "server/base/timed.h"
#include "server/query/field_queries.h"
#include "server/query/path_points.h"
#include "server/query/place.h"

namespace geodesic::server {
namespace {

using MaybePath = std::optional<Path>;

// The part of a leg's time that its field takes.
constexpr double kFieldOfLeg = 0.95;

// The way from one point to the next; nothing when there is none.
class LegFinder {
 public:
  // `legs`: how many are to be found.
  LegFinder(Fields& fields, const proto::PathRequest& request, const Caller& caller,
            std::size_t legs)
      : fields_(fields), request_(request), caller_(caller), legs_(static_cast<double>(legs)) {}

  // Whether all the fields asked for were there; nothing when none was asked for.
  [[nodiscard]] std::optional<bool> cache_hit() const { return hit_; }

  Result<MaybePath> find(const FieldQuestion& question, const SurfacePoint& to) {
    auto leg = request_.method.which == Method::steiner             ? by_refinement(question, to)
               : fields_.is_to_be_searched(question, Details::kept) ? by_search(question, to)
                                                                    : by_field(question, to);
    found_ += 1;
    return leg;
  }

 private:
  // Only where the path can be.
  Result<MaybePath> by_search(const FieldQuestion& question, const SurfacePoint& to) {
    hit_ = false;
    return fields_.compute(
        [&](SolveScratch& scratch, const Cancel& cancel) -> Result<MaybePath> {
          const PairPath path = is_refined() ? PairPath::refined : PairPath::traced;
          auto pair = fields_.search(question, to, path, scratch, cancel, caller_);
          if (!pair) return fail(std::move(pair.error()));
          return std::move(pair->path);
        },
        part_of_leg(0, 1));
  }

  // Back from the end through the field of the start: the whole field, not one that
  // stops at the target. Whoever asks for a second path from a source asks for the next
  // one as the mouse moves.
  Result<MaybePath> by_field(const FieldQuestion& question, const SurfacePoint& to) {
    const auto field = fields_.whole(question, Details::kept, part_of_leg(0, kFieldOfLeg));
    if (!field) return fail(field.error());
    hit_ = hit_.value_or(true) && field->hit;
    const Caller tracer = part_of_leg(kFieldOfLeg, 1);
    return fields_.compute(
        [&](SolveScratch&, const Cancel& cancel) -> Result<MaybePath> {
          const Timed tracing(caller_, Stage::trace);
          return path_through(*question.adjacency, *field->value, to,
                              is_refined() ? PathWork::refined : PathWork::traced, cancel);
        },
        field->hit ? tracer : tracer.finishing());
  }

  // By the method's own refinement of a path, which keeps no field.
  Result<MaybePath> by_refinement(const FieldQuestion& question, const SurfacePoint& to) {
    return fields_.compute(
        [&](SolveScratch& scratch, const Cancel& cancel) -> Result<MaybePath> {
          const Timed tracing(caller_, Stage::trace);
          auto path = steiner_path(*question.adjacency, question.sources.front(), to,
                                   request_.method.options, scratch.parts().wavefront, cancel);
          if (!path) return fail(std::move(path.error()));
          if (!*path || !is_refined()) return path;
          auto shorter = shorten_path(*question.adjacency, **path, cancel);
          if (!shorter) return fail(std::move(shorter.error()));
          return MaybePath(std::move(*shorter));
        },
        part_of_leg(0, 1));
  }

  [[nodiscard]] Caller part_of_leg(double begin, double end) const {
    return caller_.part((found_ + begin) / legs_, (found_ + end) / legs_);
  }

  [[nodiscard]] bool is_refined() const { return request_.refine != proto::Refine::none; }

  Fields& fields_;
  const proto::PathRequest& request_;
  const Caller& caller_;
  const double legs_;
  double found_ = 0;
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

}  // namespace

Result<Answered<proto::PathReply>> FieldQueries::answer(const std::string& mesh,
                                                        const proto::PathRequest& request,
                                                        const Caller& caller) {
  const auto place = find(mesh, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::PathReply> answer;
  answer.adjacency = place->adjacency();
  proto::PathReply& reply = answer.reply;
  reply.mesh = mesh;
  reply.method = request.method.which;
  reply.bound = proto::bound_of(request.method);
  reply.refine = request.refine;
  // All at once: a search for points waits for a compute slot.
  std::vector<proto::PointRequest> asked{request.from};
  asked.insert(asked.end(), request.via.begin(), request.via.end());
  asked.push_back(request.to);
  const auto points = place->points(asked, reply.via, reply.warnings);
  if (!points) return fail(points.error());
  reply.from = std::move(reply.via.front());
  reply.to = std::move(reply.via.back());
  reply.via.erase(reply.via.begin());
  reply.via.pop_back();

  LegFinder finder(fields_, request, caller, points->size() - 1);
  std::vector<Path> legs;
  for (std::size_t i = 1; i < points->size(); ++i) {
    const Source start{(*points)[i - 1], 0};
    auto leg = finder.find({mesh, place->adjacency(), request.method, {start}}, (*points)[i]);
    if (!leg) return fail(std::move(leg.error()));
    answer.cache_hit = finder.cache_hit();
    if (!*leg) return answer;  // not reachable
    legs.push_back(std::move(**leg));
  }
  const Path path = join_paths(legs);
  reply.reachable = true;
  reply.length = path.length;
  reply.points = path_points(*place->adjacency(), path);
  return answer;
}

Result<Answered<proto::TraceReply>> FieldQueries::answer(const std::string& mesh,
                                                         const proto::TraceRequest& request,
                                                         const Caller& caller) {
  const auto place = find(mesh, caller);
  if (!place) return fail(place.error());
  Answered<proto::TraceReply> answer;
  answer.adjacency = place->adjacency();
  proto::TraceReply& reply = answer.reply;
  reply.mesh = mesh;
  const auto from = place->point(request.from, reply.from, reply.warnings);
  if (!from) return fail(from.error());
  const auto found = fields_.compute(
      [&](SolveScratch&, const Cancel& cancel) {
        const Timed tracing(caller, Stage::trace);
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
  reply.points = path_points(*place->adjacency(), found->path);
  reply.to = reply_point(place->mesh(), found->path.points.back().point);
  return answer;
}

}  // namespace geodesic::server
