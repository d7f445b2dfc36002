// The surface round a point laid into the plane.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/field/longest_edge.h"
#include "core/straighten/log_map.h"
#include "server/base/timed.h"
#include "server/query/field_queries.h"
#include "server/query/place.h"

namespace geodesic::server {
namespace {

// The part of the time that the field takes, before the paths.
constexpr double kFieldOfLogmap = 0.2;
// Its own, its distance, its angle, two coordinates, and whether the way is straight.
constexpr std::uint64_t kNumbersOfVertex = 6;
constexpr std::uint64_t kNumbersOfDirection = 3;

// How many vertices of the client have a place: copies of a vertex have the same.
std::uint64_t count_places(const LogMap& map, const Mesh& mesh, Poll& poll) {
  std::vector<bool> has_place(mesh.vertex_count());
  for (const LogMap::Entry& entry : map.entries) {
    if (poll.cancelled()) break;
    has_place[entry.vertex] = true;
  }
  std::uint64_t count = 0;
  for (const std::uint32_t vertex : mesh.vertex_of_source()) {
    if (poll.cancelled()) break;
    if (vertex != kNone && has_place[vertex]) ++count;
  }
  return count;
}

// What the map says of the engine's vertices, in the client's numbers. Not all of it if the poll
// says to stop.
void take_over(const LogMap& map, const Mesh& mesh, proto::LogmapReply& reply, Poll& poll) {
  const auto is_before = [](const LogMap::Entry& e, std::uint32_t v) { return e.vertex < v; };
  for (std::uint32_t v = 0; v < mesh.source_vertex_count() && !poll.cancelled(); ++v) {
    const std::uint32_t vertex = mesh.vertex_of_source()[v];
    const auto entry = std::lower_bound(map.entries.begin(), map.entries.end(), vertex, is_before);
    if (entry == map.entries.end() || entry->vertex != vertex) continue;
    const Vec2 at = map.coordinates(*entry, reply.angle);
    reply.vertices.push_back(v);
    reply.distances.push_back(entry->distance);
    reply.angles.push_back(entry->angle);
    reply.straight.push_back(entry->is_straight ? 1 : 0);
    reply.coordinates.push_back({at.x, at.y});
    if (!reply.directions) continue;
    const Vec3 d = map.directions[static_cast<std::size_t>(entry - map.entries.begin())];
    reply.directions->push_back({d.x, d.y, d.z});
  }
}

}  // namespace

Result<Answered<proto::LogmapReply>> FieldQueries::answer(const AskedSurface& surface,
                                                          const proto::LogmapRequest& request,
                                                          const Caller& caller) {
  const auto place = find(surface, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::LogmapReply> answer;
  answer.adjacency = place->adjacency();
  proto::LogmapReply& reply = answer.reply;
  reply.mesh = surface.mesh();
  reply.method = request.method.which;
  reply.angle = request.angle;
  if (request.transport) reply.directions.emplace();
  auto from = place->point(request.from, reply.from, reply.warnings);
  if (!from) return fail(from.error());
  *from = snap_to_edges(*place->adjacency(), *from);
  const proto::ResolvedPoint found_there = place->told(*from);
  reply.from.vertex = found_there.vertex;
  reply.from.face = found_there.face;
  reply.from.bary = found_there.bary;
  FieldQuestion question{
      surface.key(), place->adjacency(), request.method, {{Source{*from, 0}}, nullptr, {}}};
  // A path to a vertex at the radius may need the vertices just beyond it.
  const double radius = request.radius.value_or(kUnreached);
  question.max = kFieldBeyondRadius * radius + 2 * longest_edge(*place->adjacency());
  const auto field = fields_.whole(question, Details::kept, caller.part(0, kFieldOfLogmap));
  if (!field) return fail(field.error());
  answer.cache_hit = field->hit;
  const Caller mapper = caller.part(kFieldOfLogmap, 1);
  auto found = fields_.compute(
      [&](SolveScratch&, const Cancel& cancel) -> Result<LogMap> {
        const Timed tracing(caller, Stage::trace);
        auto map = log_map(*place->adjacency(), *field->value, *from, radius, cancel,
                           request.transport ? std::optional(request.angle) : std::nullopt);
        Poll poll(cancel);
        const std::uint64_t each = kNumbersOfVertex + (request.transport ? kNumbersOfDirection : 0);
        if (map) answer.numbers = each * count_places(*map, place->mesh(), poll);
        if (poll.stopped()) return fail_stopped(poll);
        return map;
      },
      field->hit ? mapper : mapper.finishing());
  if (!found) return fail(std::move(found.error()));
  reply.total_angle = found->total_angle;
  reply.all_round = found->all_round;
  for (const LogMap::Entry& entry : found->entries) {
    reply.radius = std::max(reply.radius, entry.distance);
  }
  if (request.radius) reply.radius = *request.radius;
  const auto map = std::make_shared<const LogMap>(std::move(*found));
  answer.complete = [map, adjacency = place->adjacency()](proto::LogmapReply& to,
                                                          const Cancel& cancel) -> Result<void> {
    Poll poll(cancel);
    take_over(*map, adjacency->mesh(), to, poll);
    if (poll.stopped()) return fail_stopped(poll);
    return {};
  };
  return answer;
}

}  // namespace geodesic::server
