// Queries for ways over the surface.
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/locate/plane_section.h"
#include "core/paths/join_paths.h"
#include "core/solve/scratch_parts.h"
#include "core/solve/solve_from_lines.h"
#include "core/steiner/path.h"
#include "core/straighten/loop_straightness.h"
#include "core/straighten/refine_path.h"
#include "core/straighten/shorten_path.h"
#include "core/straighten/straightest_geodesic.h"
#include "core/straighten/tighten_loop.h"
#include "server/base/service_codes.h"
#include "server/base/timed.h"
#include "server/query/field_queries.h"
#include "server/query/path_points.h"
#include "server/query/place.h"

namespace geodesic::server {
namespace {

using MaybePath = std::optional<Path>;

// The part of a leg's time that its field takes.
constexpr double kFieldOfLeg = 0.95;
// What a distance by `auto` may be below the truth, with room.
constexpr double kBeyond = 1.01;

// The way from one point to the next; nothing when there is none.
class LegFinder {
 public:
  // `legs`: how many are to be found.
  LegFinder(Fields& fields, const proto::MethodChoice& method, proto::Refine refine,
            std::shared_ptr<const TravelCost> cost, const Caller& caller, std::size_t legs)
      : fields_(fields),
        method_(method),
        refine_(refine),
        cost_(std::move(cost)),
        caller_(caller),
        legs_(static_cast<double>(legs)) {}

  // Whether all the fields asked for were there; nothing when none was asked for.
  [[nodiscard]] std::optional<bool> cache_hit() const { return hit_; }

  // From each point to the next, the first of them from whatever `from` has; ends before the first
  // that is not to be reached.
  Result<std::vector<Path>> find_all(const std::string& surface,
                                     const std::shared_ptr<const Adjacency>& adjacency,
                                     const std::vector<SurfacePoint>& points,
                                     const FieldSources* from = nullptr) {
    std::vector<Path> legs;
    for (std::size_t i = from == nullptr ? 1 : 0; i < points.size(); ++i) {
      auto leg =
          i == 0 ? find({surface, adjacency, method_, *from}, points[i])
                 : find({surface, adjacency, method_, {{Source{points[i - 1], 0}}, nullptr, {}}},
                        points[i]);
      if (!leg) return fail(std::move(leg.error()));
      if (!*leg) break;
      legs.push_back(std::move(**leg));
    }
    return legs;
  }

 private:
  Result<MaybePath> find(const FieldQuestion& question, const SurfacePoint& to) {
    auto leg = question.from.lines                                  ? from_lines(question, to)
               : method_.which == Method::steiner                   ? by_refinement(question, to)
               : fields_.is_to_be_searched(question, Details::kept) ? by_search(question, to)
                                                                    : by_field(question, to);
    found_ += 1;
    return leg;
  }

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

  // By `auto` a wave from lines goes by windows, of which it keeps none to lead back. By `exact`
  // they are kept, no farther out than need be; steps of the distance are few fields to keep.
  Result<MaybePath> from_lines(const FieldQuestion& question, const SurfacePoint& to) {
    if (method_.which != Method::back_traced) return by_field(question, to);
    const std::array<SurfacePoint, 1> target{to};
    const auto about = fields_.at_points(question, target, false, part_of_leg(0, kFieldOfLeg / 2));
    if (!about) return fail(about.error());
    const double distance = about->distances.front();
    if (distance == kUnreached) return MaybePath();
    FieldQuestion exactly = question;
    exactly.method = {};
    exactly.method.which = Method::exact;
    exactly.max = std::exp2(std::ceil(2 * std::log2(distance * kBeyond)) / 2);
    auto leg = by_field(exactly, to);
    if (leg || leg.error().code != ServiceCode::too_much_memory) return leg;
    return by_field(question, to);
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
          return path_from_lines(*question.adjacency, *field->value, to,
                                 is_refined() ? PathWork::refined : PathWork::traced, cancel);
        },
        field->hit ? tracer : tracer.finishing());
  }

  // By the method's own refinement of a path, which keeps no field.
  Result<MaybePath> by_refinement(const FieldQuestion& question, const SurfacePoint& to) {
    return fields_.compute(
        [&](SolveScratch& scratch, const Cancel& cancel) -> Result<MaybePath> {
          const Timed tracing(caller_, Stage::trace);
          auto path = steiner_path(*question.adjacency, question.from.points.front(), to,
                                   method_.options, scratch.parts().wavefront, cancel, cost_);
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

  [[nodiscard]] bool is_refined() const { return refine_ != proto::Refine::none; }

  Fields& fields_;
  const proto::MethodChoice& method_;
  const proto::Refine refine_;
  const std::shared_ptr<const TravelCost> cost_;  // null: lengths
  const Caller& caller_;
  const double legs_;
  double found_ = 0;
  std::optional<bool> hit_;
};

// What each segment costs and how long it is.
void tell_costs(const Path& path, const TravelCost& cost, proto::PathCosts& told) {
  told.costs = segment_costs(path, cost);
  told.lengths.reserve(told.costs.size());
  for (std::size_t i = 0; i < told.costs.size(); ++i) {
    told.lengths.push_back(distance(path.points[i].position, path.points[i + 1].position));
    told.whole += told.costs[i];
  }
}

// The part of a loop's time that its legs take.
constexpr double kLegsOfLoop = 0.9;

// The corners of the section's convex hull, which the segments between them need not touch.
Result<Path> hull_of(const Mesh& mesh, const Path& section, Vec3 normal, const Cancel& cancel) {
  std::vector<Vec3> positions;
  for (const PathPoint& point : section.points) positions.push_back(point.position);
  positions.pop_back();  // the first again
  const auto corners = hull_in_plane(positions, normal, cancel);
  if (!corners) return fail(corners.error());
  std::vector<SurfacePoint> hull;
  for (const std::uint32_t corner : *corners) hull.push_back(section.points[corner].point);
  return closed_path_along(mesh, hull);
}

// Where the plane that is asked for cuts the surface: that at a right angle to `normal`, or through
// three points.
Result<SectionOfPoints> section_of(const Adjacency& adjacency, const proto::LoopRequest& request,
                                   const std::vector<SurfacePoint>& points, const Cancel& cancel) {
  if (request.start == proto::LoopRequest::Start::around) {
    return section_through(adjacency, {points[0], points[1], points[2]}, cancel);
  }
  auto section = plane_section(adjacency, points.front(), request.normal, cancel);
  if (!section) return fail(std::move(section.error()));
  return SectionOfPoints{std::move(*section), request.normal};
}

// The loop that is asked for, and what the reply says of its shape. `legs` are from point to point
// and back to the first; none of a plane.
Result<Path> find_loop(const Adjacency& adjacency, const proto::LoopRequest& request,
                       const std::vector<SurfacePoint>& points, const std::vector<Path>& legs,
                       proto::LoopReply& reply, const Cancel& cancel) {
  using Start = proto::LoopRequest::Start;
  Path loop;
  Vec3 normal;
  if (request.is_of_plane()) {
    const auto section = section_of(adjacency, request, points, cancel);
    if (!section) return fail(section.error());
    normal = section->normal;
    loop = closed_path_along(adjacency.mesh(), section->points);
  } else {
    loop = join_paths(legs);
  }
  reply.start_length = loop.length;
  if (!(loop.length > 0)) {
    return fail(ErrorCode::no_loop, "all of these points are at one place");
  }
  if (request.hull) return hull_of(adjacency.mesh(), loop, normal, cancel);
  if (request.start != Start::through) {
    auto tight = tighten_loop(adjacency, loop, cancel);
    if (!tight) return fail(std::move(tight.error()));
    loop = std::move(tight->path);
    if (!tight->is_finished) {
      reply.warnings.emplace_back(
          "The loop was not tightened to the end: it crosses too many faces, or faces without "
          "area. "
          "It may be longer than the closed geodesic near it.");
    }
  }
  const auto straightness = straightness_of_loop(adjacency, loop, cancel);
  if (!straightness) return fail(straightness.error());
  if (straightness->is_known) {
    reply.turn = straightness->turn * 180 / std::numbers::pi;
    reply.is_geodesic = straightness->lack <= kMostLack;
  }
  return loop;
}

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

Result<Answered<proto::PathReply>> FieldQueries::answer(const AskedSurface& surface,
                                                        const proto::PathRequest& request,
                                                        const Caller& caller) {
  const auto place = find(surface, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::PathReply> answer;
  answer.adjacency = place->adjacency();
  proto::PathReply& reply = answer.reply;
  reply.mesh = surface.mesh();
  reply.method = request.method.which;
  reply.bound = proto::bound_of(request.method);
  reply.refine = request.refine;
  // All at once: a search for points waits for a compute slot.
  std::vector<proto::PointRequest> asked;
  if (request.from.is_point()) asked.push_back(request.from);
  asked.insert(asked.end(), request.via.begin(), request.via.end());
  asked.push_back(request.to);
  const auto points = place->points(asked, reply.via, reply.warnings);
  if (!points) return fail(points.error());
  reply.to = std::move(reply.via.back());
  reply.via.pop_back();
  std::optional<FieldSources> from;
  if (request.from.is_point()) {
    reply.from = std::move(reply.via.front());
    reply.via.erase(reply.via.begin());
  } else {
    std::vector<proto::ResolvedPoint> echo;
    auto sources = place->sources({request.from}, echo, reply.warnings);
    if (!sources) return fail(std::move(sources.error()));
    from = std::move(*sources);
    reply.from = std::move(echo.front());
  }

  const std::size_t wanted = points->size() - (from ? 0 : 1);
  LegFinder finder(fields_, request.method, request.refine, place->cost(), caller, wanted);
  const auto legs =
      finder.find_all(surface.key(), place->adjacency(), *points, from ? &*from : nullptr);
  if (!legs) return fail(legs.error());
  answer.cache_hit = finder.cache_hit();
  if (place->cost()) reply.costs.emplace().unit = proto::unit_of(surface.costs());
  place->warn_of_steep_ground(reply.warnings);
  if (legs->size() < wanted) return answer;  // not reachable
  const Path path = join_paths(*legs);
  if (place->cost()) tell_costs(path, *place->cost(), *reply.costs);
  reply.reachable = true;
  reply.length = path.length;
  reply.points = path_points(*place->adjacency(), place->refinement(), path);
  return answer;
}

Result<Answered<proto::LoopReply>> FieldQueries::answer(const AskedSurface& surface,
                                                        const proto::LoopRequest& request,
                                                        const Caller& caller) {
  const bool has_legs = !request.is_of_plane();
  const auto place = has_legs ? find(surface, request.method, caller) : find(surface, caller);
  if (!place) return fail(place.error());
  Answered<proto::LoopReply> answer;
  answer.adjacency = place->adjacency();
  proto::LoopReply& reply = answer.reply;
  reply.mesh = surface.mesh();
  reply.start = request.start;
  reply.is_hull = request.hull;
  const auto points = place->points(request.points, reply.asked, reply.warnings);
  if (!points) return fail(points.error());
  std::vector<Path> legs;
  if (has_legs) {
    reply.method = request.method.which;
    std::vector<SurfacePoint> round = *points;
    round.push_back(round.front());
    const Caller walker = caller.part(0, kLegsOfLoop);
    LegFinder finder(fields_, request.method, proto::Refine::shortest, nullptr, walker,
                     points->size());
    auto found = finder.find_all(surface.key(), place->adjacency(), round);
    if (!found) return fail(std::move(found.error()));
    answer.cache_hit = finder.cache_hit();
    legs = std::move(*found);
    if (legs.size() < points->size()) {
      return fail(ErrorCode::no_loop, "no way leads from this point to the next one",
                  request.points[legs.size()].parameter);
    }
    // What is tightened is no method's any more.
    if (request.start == proto::LoopRequest::Start::through) {
      reply.bound = proto::bound_of(request.method);
    }
  } else if (request.start == proto::LoopRequest::Start::plane) {
    reply.normal = request.normal;
  }
  const Caller tightener = has_legs ? caller.part(kLegsOfLoop, 1) : caller;
  const bool had_slot = has_legs && !answer.cache_hit.value_or(false);
  auto loop = fields_.compute(
      [&](SolveScratch&, const Cancel& cancel) {
        const Timed tracing(caller, Stage::trace);
        return find_loop(*place->adjacency(), request, *points, legs, reply, cancel);
      },
      had_slot ? tightener.finishing() : tightener);
  if (!loop) {
    // Where the plane is to blame, the error says so.
    if (loop.error().code == ErrorCode::no_loop && loop.error().parameter.empty()) {
      loop.error().parameter =
          request.start == proto::LoopRequest::Start::plane ? "at" : name_of(request.start);
    }
    return fail(std::move(loop.error()));
  }
  reply.length = loop->length;
  reply.points = path_points(*place->adjacency(), place->refinement(), *loop);
  return answer;
}

Result<Answered<proto::TraceReply>> FieldQueries::answer(const AskedSurface& surface,
                                                         const proto::TraceRequest& request,
                                                         const Caller& caller) {
  const auto place = find(surface, caller);
  if (!place) return fail(place.error());
  Answered<proto::TraceReply> answer;
  answer.adjacency = place->adjacency();
  proto::TraceReply& reply = answer.reply;
  reply.mesh = surface.mesh();
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
  reply.points = path_points(*place->adjacency(), place->refinement(), found->path);
  reply.to = place->told(found->path.points.back().point);
  return answer;
}

}  // namespace geodesic::server
