// What the discs about some sources measure.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/field/longest_edge.h"
#include "core/field/nearest_copies.h"
#include "core/paths/discs.h"
#include "core/paths/strips.h"
#include "proto/wire/query_limits.h"
#include "server/query/field_queries.h"
#include "server/query/place.h"

namespace geodesic::server {
namespace {

// The part of the time that the field takes, before the discs.
constexpr double kFieldOfMeasure = 0.8;

// The first of the client's vertices that are farthest, but no farther than `most`. One at a wall
// is as far as the nearer of its sides.
Result<void> find_farthest(const Mesh& mesh, const Field& field, double most,
                           proto::MeasureReply& reply, const Cancel& cancel) {
  Poll poll(cancel);
  const auto nearer = nearer_copies(
      mesh, [&](std::uint32_t v) { return field.distance[v]; }, poll);
  for (std::uint32_t v = 0; v < mesh.source_vertex_count(); ++v) {
    if (poll.cancelled()) return fail_stopped(poll);
    const std::uint32_t vertex = mesh.vertex_of_source()[v];
    const double d = vertex == kNone ? kUnreached : field.distance[nearest_copy(nearer, vertex)];
    if (d > most || d == kUnreached || (reply.max && d <= *reply.max)) continue;
    reply.max = d;
    reply.farthest = v;
  }
  return {};
}

// Each once.
void insert_sorted(std::vector<double>& values, double value) {
  const auto at = std::lower_bound(values.begin(), values.end(), value);
  if (at == values.end() || *at != value) values.insert(at, value);
}

// Fills in the discs, and what is said of all that is reached.
Result<std::uint64_t> measure(const Adjacency& adjacency, const Field& field,
                              const std::vector<double>& radii, double most,
                              proto::MeasureReply& reply, const Cancel& cancel) {
  reply.max.reset();  // it may be run again
  reply.farthest.reset();
  if (auto found = find_farthest(adjacency.mesh(), field, most, reply, cancel); !found) {
    return fail(std::move(found.error()));
  }
  reply.reach = std::min(most, field.max);
  std::vector<double> all = radii;
  insert_sorted(all, reply.reach);
  auto measured = measure_discs(adjacency, field, all, cancel);
  if (!measured) return fail(std::move(measured.error()));
  reply.discs.clear();
  for (const Disc& disc : measured->discs) {
    if (disc.radius == reply.reach) {
      reply.area = disc.area;
      reply.mean = disc.mean;
    }
    if (std::binary_search(radii.begin(), radii.end(), disc.radius)) reply.discs.push_back(disc);
  }
  return measured->crossings;
}

// Where the strips begin and end: from the sources to the end, and at the radii between.
std::vector<double> levels_of_strips(const std::vector<double>& radii, double reach) {
  std::vector<double> levels;
  for (const double radius : radii) {
    if (radius < reach) levels.push_back(radius);
  }
  insert_sorted(levels, 0);
  insert_sorted(levels, reach);
  return levels;
}

}  // namespace

Result<Answered<proto::MeasureReply>> FieldQueries::answer(const AskedSurface& surface,
                                                           const proto::MeasureRequest& request,
                                                           const Caller& caller) {
  const auto place = find(surface, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::MeasureReply> answer;
  answer.adjacency = place->adjacency();
  proto::MeasureReply& reply = answer.reply;
  reply.mesh = surface.mesh();
  reply.method = request.method.which;
  reply.bound = proto::bound_of(request.method);
  auto sources = place->sources(request.from, reply.from, reply.warnings);
  if (!sources) return fail(std::move(sources.error()));
  FieldQuestion question{surface.key(), place->adjacency(), request.method, std::move(*sources)};
  // A disc as large as `max` needs the vertices just beyond it.
  if (request.max) question.max = *request.max + 2 * longest_edge(*place->adjacency());
  const auto field = fields_.whole(question, Details::none, caller.part(0, kFieldOfMeasure));
  if (!field) return fail(field.error());
  answer.cache_hit = field->hit;
  const Caller rest = caller.part(kFieldOfMeasure, 1);
  const auto crossings = fields_.compute(
      [&](SolveScratch&, const Cancel& cancel) {
        return measure(*place->adjacency(), *field->value, request.radii,
                       request.max.value_or(kUnreached), reply, cancel);
      },
      field->hit ? rest : rest.finishing());
  if (!crossings) return fail(crossings.error());
  const std::uint64_t count = *crossings;
  if (count <= proto::kMaxIsolineSegments) {
    // A corner of a triangle, or a coordinate, takes a third of what a number of a line does.
    answer.drawn_numbers = most_faces_of_strips(place->mesh().face_count(), count) +
                           most_vertices_of_strips(place->mesh().vertex_count(), count);
  }
  answer.complete_drawing = [adjacency = place->adjacency(), kept = field->value, count,
                             levels = levels_of_strips(request.radii, reply.reach)](
                                proto::MeasureReply& to, const Cancel& cancel) -> Result<void> {
    if (count > proto::kMaxIsolineSegments) {
      return fail_limit(ErrorCode::too_large, "so many radii cut too many faces",
                        proto::kMaxIsolineSegments, count, "radii");
    }
    auto strips = cut_strips(*adjacency, *kept, levels, cancel);
    if (!strips) return fail(std::move(strips.error()));
    to.strips = std::move(*strips);
    return {};
  };
  return answer;
}

}  // namespace geodesic::server
