// Queries about how distances spread over the whole surface: isolines, samples and extents.
#include <algorithm>
#include <limits>
#include <memory>
#include <utility>
#include <variant>

#include "core/extent/extent.h"
#include "core/extent/mean_distances.h"
#include "core/field/longest_edge.h"
#include "core/field/nearest_copies.h"
#include "core/paths/isolines.h"
#include "core/solve/farthest_points.h"
#include "proto/wire/query_limits.h"
#include "server/base/timed.h"
#include "server/query/field_queries.h"
#include "server/query/place.h"

namespace geodesic::server {
namespace {

using Levels = decltype(proto::IsolinesRequest::levels);

// The part of the time that the field takes, before the lines.
constexpr double kFieldOfIsolines = 0.9;

// With which a mean that is estimated is within its bounds.
constexpr double kConfidenceOfMean = 0.95;

const char* parameter_of(const Levels& levels) {
  if (std::holds_alternative<std::vector<double>>(levels)) return "levels";
  return std::holds_alternative<proto::IsolinesRequest::Step>(levels) ? "step" : "count";
}

// The levels up to `max`, ascending.
Result<std::vector<double>> levels_within(const Levels& asked, double max) {
  std::vector<double> levels;
  if (const auto* given = std::get_if<std::vector<double>>(&asked)) {
    std::copy_if(given->begin(), given->end(), std::back_inserter(levels),
                 [&](double level) { return level <= max; });
  } else if (const auto* step = std::get_if<proto::IsolinesRequest::Step>(&asked)) {
    const double steps = max / step->size;
    if (!(steps < proto::kMaxLevels + 1)) {
      return fail_limit(ErrorCode::too_large, "so small a step makes too many levels",
                        proto::kMaxLevels, static_cast<std::uint64_t>(std::min(steps, 1e18)),
                        "step");
    }
    for (int i = 1; i * step->size <= max; ++i) levels.push_back(i * step->size);
  } else if (max > 0) {
    const auto count = static_cast<double>(std::get<proto::IsolinesRequest::Count>(asked).levels);
    for (double i = 1; i <= count; ++i) levels.push_back(i / (count + 1) * max);
    levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  }
  return levels;
}

void take_means(const Mesh& mesh, const MeanDistances& means, proto::ExtentReply& reply,
                Poll& poll) {
  reply.means.reserve(mesh.source_vertex_count());
  reply.margins.reserve(mesh.source_vertex_count());
  for (const std::uint32_t v : nearest_copies(mesh, means.mean, poll)) {
    if (poll.cancelled()) return;
    const bool is_known = v != kNone && means.mean[v] != kUnreached;
    reply.means.push_back(is_known ? means.mean[v] : kUnreached);
    reply.margins.push_back(is_known ? means.margin[v] : kUnreached);
  }
}

ExtentOf measure_of(proto::ExtentRequest::Of of) {
  switch (of) {
    case proto::ExtentRequest::Of::diameter:
      return ExtentOf::diameter;
    case proto::ExtentRequest::Of::center:
      return ExtentOf::center;
    case proto::ExtentRequest::Of::median:
      return ExtentOf::median;
    case proto::ExtentRequest::Of::mean:
    case proto::ExtentRequest::Of::means:  // not asked here
      break;
  }
  return ExtentOf::mean;
}

}  // namespace

Result<Answered<proto::IsolinesReply>> FieldQueries::answer(const AskedSurface& surface,
                                                            const proto::IsolinesRequest& request,
                                                            const Caller& caller) {
  const auto place = find(surface, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::IsolinesReply> answer;
  answer.adjacency = place->adjacency();
  proto::IsolinesReply& reply = answer.reply;
  reply.mesh = surface.mesh();
  reply.method = request.method.which;
  auto sources = place->sources(request.from, reply.from, reply.warnings);
  if (!sources) return fail(std::move(sources.error()));
  FieldQuestion question{surface.field_key(), place->adjacency(), request.method,
                         std::move(*sources)};
  question.cost = place->cost();
  if (place->cost()) reply.unit = proto::unit_of(surface.costs());
  place->warn_of_steep_ground(reply.warnings);
  // A line at `max` needs the vertices just beyond it. What a step costs there, nobody knows.
  if (request.max && !place->cost()) {
    question.max = *request.max + 2 * longest_edge(*place->adjacency());
  }
  const auto field = fields_.whole(question, Details::none, caller.part(0, kFieldOfIsolines));
  if (!field) return fail(field.error());
  answer.cache_hit = field->hit;

  if (field->value->reached > 0) {
    reply.max = std::min(field->value->max, request.max.value_or(field->value->max));
  }
  auto levels = levels_within(request.levels, reply.max.value_or(0));
  if (!levels) return fail(std::move(levels.error()));
  reply.levels = std::move(*levels);
  const Caller tracer = caller.part(kFieldOfIsolines, 1);
  auto lines = fields_.compute(
      [&](SolveScratch&, const Cancel& cancel) {
        return isolines(*place->adjacency(), *field->value, reply.levels,
                        proto::kMaxIsolineSegments, cancel);
      },
      field->hit ? tracer : tracer.finishing());
  if (!lines) {
    if (lines.error().code == ErrorCode::too_large) {
      lines.error().parameter = parameter_of(request.levels);
    }
    return fail(std::move(lines.error()));
  }
  reply.isolines = std::move(*lines);
  return answer;
}

Result<Answered<proto::SamplesReply>> FieldQueries::answer(const AskedSurface& surface,
                                                           const proto::SamplesRequest& request,
                                                           const Caller& caller) {
  const auto place = find(surface, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::SamplesReply> answer;
  answer.adjacency = place->adjacency();
  proto::SamplesReply& reply = answer.reply;
  reply.mesh = surface.mesh();
  reply.method = request.method.which;
  reply.bound = proto::bound_of(request.method);
  const auto sources = place->sources(request.from, reply.from, reply.warnings);
  if (!sources) return fail(sources.error());
  const auto found = fields_.compute(
      [&](SolveScratch& scratch, const Cancel& cancel) {
        return farthest_points(request.method.which, request.method.options, *place->adjacency(),
                               sources->points, sources->lines, request.count, scratch, cancel);
      },
      caller);
  if (!found) return fail(found.error());
  reply.covering_radius = found->covering_radius;
  reply.samples.reserve(found->points.size());
  for (const FarthestPoint& point : found->points) {
    reply.samples.push_back({place->mesh().source_of_vertex(point.vertex),
                             place->mesh().positions()[point.vertex], point.radius});
  }
  return answer;
}

Result<Answered<proto::ExtentReply>> FieldQueries::answer(const AskedSurface& surface,
                                                          const proto::ExtentRequest& request,
                                                          const Caller& caller) {
  const auto place = find(surface, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::ExtentReply> answer;
  answer.adjacency = place->adjacency();
  proto::ExtentReply& reply = answer.reply;
  reply.mesh = surface.mesh();
  reply.method = request.method.which;
  reply.of = request.of;
  if (request.of == proto::ExtentRequest::Of::means) {
    const auto means = fields_.compute(
        [&](SolveScratch& scratch, const Cancel& cancel) {
          const Timed solving(caller, Stage::solve);
          return mean_distances(request.method.which, request.method.options, *place->adjacency(),
                                request.fields, scratch, cancel);
        },
        caller);
    if (!means) return fail(means.error());
    reply.value = means->overall;
    reply.lower = means->lower;
    reply.upper = means->upper;
    reply.confidence = means->is_exact ? 1 : kConfidenceOfMean;
    reply.is_exact = means->is_exact;
    reply.fields = means->fields;
    reply.part_vertices = means->part_vertices;
    answer.numbers = std::uint64_t{2} * place->mesh().source_vertex_count();
    if (place->refinement() != nullptr) {
      auto drawn = std::make_shared<Field>();
      drawn->distance.doubles() = means->mean;
      answer.drawn_field = std::move(drawn);
    }
    answer.complete = [adjacency = place->adjacency(),
                       kept = std::make_shared<const MeanDistances>(std::move(*means))](
                          proto::ExtentReply& whole, const Cancel& cancel) -> Result<void> {
      Poll poll(cancel);
      take_means(adjacency->mesh(), *kept, whole, poll);
      if (poll.stopped()) return fail_stopped(poll);
      return {};
    };
    return answer;
  }
  const auto found = fields_.compute(
      [&](SolveScratch& scratch, const Cancel& cancel) {
        const Timed solving(caller, Stage::solve);
        return extent(measure_of(request.of), request.method.which, request.method.options,
                      *place->adjacency(), request.fields, scratch, cancel);
      },
      caller);
  if (!found) return fail(found.error());
  reply.value = found->value;
  reply.lower = found->lower;
  reply.upper = found->upper;
  reply.confidence =
      request.of == proto::ExtentRequest::Of::mean && !found->is_exact ? kConfidenceOfMean : 1;
  reply.is_exact = found->is_exact;
  reply.fields = found->fields;
  reply.part_vertices = found->part_vertices;
  for (const std::uint32_t v : found->vertices) {
    reply.vertices.push_back({place->mesh().source_of_vertex(v), place->mesh().positions()[v]});
  }
  return answer;
}

}  // namespace geodesic::server
