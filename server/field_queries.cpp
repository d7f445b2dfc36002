#include "server/field_queries.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <utility>

#include "core/arrive_at_point.h"
#include "core/trace_path.h"
#include "proto/number.h"
#include "server/resolve_point.h"

namespace geodesic::server {
namespace {

// What a field depends on, spelt out; two spellings of one point are one key.
std::string field_key(const std::string& mesh, proto::Method method,
                      const std::vector<Source>& sources, double max) {
  std::string key = mesh + "/";
  key += proto::name_of(method);
  key += "/";
  proto::append_number(key, max);
  for (const Source& source : sources) {
    if (source.point.at_vertex()) {
      key += "/v" + std::to_string(source.point.vertex);
    } else {
      key += "/f" + std::to_string(source.point.face);
      for (const double weight : source.point.bary) {
        key += ",";
        proto::append_number(key, weight);
      }
    }
    if (source.offset != 0) {
      key += "+";
      proto::append_number(key, source.offset);
    }
  }
  return key;
}

// The points of one request on one mesh.
class Resolver {
 public:
  Resolver(MeshCatalog& catalog, const std::string& mesh, const Adjacency& adjacency,
           const ClientGone& client_gone)
      : adjacency_(adjacency), closest_([&catalog, &mesh, &client_gone] {
          return catalog.closest_points(mesh, client_gone);
        }) {}

  [[nodiscard]] Result<PlacedPoint> one(const proto::PointRequest& request) const {
    return resolve_point(adjacency_, closest_, request);
  }

  // The places, and what the reply says of them in `echo`.
  [[nodiscard]] Result<std::vector<SurfacePoint>> all(
      const std::vector<proto::PointRequest>& requests,
      std::vector<proto::ResolvedPoint>& echo) const {
    std::vector<SurfacePoint> points;
    points.reserve(requests.size());
    for (const proto::PointRequest& request : requests) {
      auto placed = one(request);
      if (!placed) return fail(std::move(placed.error()));
      points.push_back(placed->point);
      echo.push_back(std::move(placed->echo));
    }
    return points;
  }

 private:
  const Adjacency& adjacency_;
  ClosestPoints closest_;
};

// Every vertex whose distance decides that of one of the points.
std::vector<std::uint32_t> vertices_about(const Adjacency& adjacency,
                                          const std::vector<SurfacePoint>& points) {
  std::vector<std::uint32_t> vertices;
  for (const SurfacePoint& point : points) {
    if (point.at_vertex()) {
      vertices.push_back(point.vertex);
      continue;
    }
    for (const SurfacePoint& place : in_all_faces(adjacency, point)) {
      for (const std::uint32_t v : adjacency.face(place.face).vertex) vertices.push_back(v);
    }
  }
  return vertices;
}

// Fills `reached`, `max` and `farthest` from the distances.
void summarise(proto::DistanceReply& reply) {
  for (std::size_t i = 0; i < reply.distances.size(); ++i) {
    const double d = reply.distances[i];
    if (d == kUnreached) continue;
    ++reply.reached;
    if (!reply.max || d > *reply.max) {
      reply.max = d;
      reply.farthest = i;
    }
  }
}

}  // namespace

FieldQueries::FieldQueries(MeshCatalog& catalog, ComputePool& pool, std::uint64_t field_cache_bytes)
    : catalog_(catalog),
      pool_(pool),
      fields_(field_cache_bytes, [](const Field& field) { return field.bytes(); }),
      scratch_(pool.slots()) {}

Result<Field> FieldQueries::solve(const Adjacency& adjacency, proto::Method method,
                                  const std::vector<Source>& sources, const FieldLimits& limits,
                                  const ClientGone& client_gone) {
  return pool_.run(
      [&](Worker& worker) -> Result<Field> {
        switch (method) {
          case proto::Method::wavefront:
            return wavefront_field(adjacency, sources, limits, scratch_[worker.slot],
                                   Cancel(client_gone));
        }
        return fail(ErrorCode::internal, "a method without an implementation");
      },
      client_gone);
}

Result<LruCache<Field>::Lookup> FieldQueries::whole_field(
    const std::string& mesh, const Adjacency& adjacency, proto::Method method,
    const std::vector<Source>& sources, double max, const ClientGone& client_gone) {
  return fields_.get_or_create(
      field_key(mesh, method, sources, max), [&]() -> Result<std::shared_ptr<const Field>> {
        FieldLimits limits;
        limits.max = max;
        auto field = solve(adjacency, method, sources, limits, client_gone);
        if (!field) return fail(std::move(field.error()));
        return std::make_shared<const Field>(std::move(*field));
      });
}

Result<Answered<proto::DistanceReply>> FieldQueries::distance(const std::string& mesh,
                                                              const proto::DistanceRequest& request,
                                                              const ClientGone& client_gone) {
  const auto adjacency = catalog_.adjacency(mesh, client_gone);
  if (!adjacency) return fail(adjacency.error());
  const Resolver resolver(catalog_, mesh, **adjacency, client_gone);

  Answered<proto::DistanceReply> answer;
  proto::DistanceReply& reply = answer.reply;
  reply.mesh = mesh;
  reply.method = request.method;
  auto from = resolver.all(request.from, reply.from);
  if (!from) return fail(std::move(from.error()));
  std::vector<Source> sources;
  for (std::size_t i = 0; i < from->size(); ++i) {
    sources.push_back({(*from)[i], request.from[i].offset});
  }
  const double max = request.max.value_or(std::numeric_limits<double>::infinity());

  if (request.at.empty()) {
    const auto field = whole_field(mesh, **adjacency, request.method, sources, max, client_gone);
    if (!field) return fail(field.error());
    answer.cache_hit = field->hit;
    const auto vertex_of_source = (*adjacency)->mesh().vertex_of_source();
    reply.distances.reserve(vertex_of_source.size());
    for (const std::uint32_t v : vertex_of_source) {
      reply.distances.push_back(field->value->distance[v]);
    }
    summarise(reply);
    return answer;
  }

  auto at = resolver.all(request.at, reply.at.emplace());
  if (!at) return fail(std::move(at.error()));
  // For a few points: a field that is there already, or one that stops at them.
  std::shared_ptr<const Field> field = fields_.find(field_key(mesh, request.method, sources, max));
  answer.cache_hit = field != nullptr;
  if (!field) {
    const std::vector<std::uint32_t> targets = vertices_about(**adjacency, *at);
    auto part = solve(**adjacency, request.method, sources, {max, targets}, client_gone);
    if (!part) return fail(std::move(part.error()));
    field = std::make_shared<const Field>(std::move(*part));
  }
  const PointArrivals arrivals(**adjacency, *field);
  for (const SurfacePoint& point : *at) {
    const double d = arrivals.distance_at(point);
    reply.distances.push_back(d <= max ? d : kUnreached);
  }
  summarise(reply);
  return answer;
}

Result<Answered<proto::PathReply>> FieldQueries::path(const std::string& mesh,
                                                      const proto::PathRequest& request,
                                                      const ClientGone& client_gone) {
  const auto adjacency = catalog_.adjacency(mesh, client_gone);
  if (!adjacency) return fail(adjacency.error());
  const Resolver resolver(catalog_, mesh, **adjacency, client_gone);
  auto from = resolver.one(request.from);
  if (!from) return fail(std::move(from.error()));
  auto to = resolver.one(request.to);
  if (!to) return fail(std::move(to.error()));

  // The whole field, not one that stops at the target: whoever asks for one path
  // from a source asks for the next one as the mouse moves.
  const auto field = whole_field(mesh, **adjacency, request.method, {Source{from->point, 0}},
                                 std::numeric_limits<double>::infinity(), client_gone);
  if (!field) return fail(field.error());

  Answered<proto::PathReply> answer;
  answer.cache_hit = field->hit;
  proto::PathReply& reply = answer.reply;
  reply.mesh = mesh;
  reply.method = request.method;
  reply.from = std::move(from->echo);
  reply.to = std::move(to->echo);
  const auto path = trace_path(**adjacency, *field->value, to->point);
  if (!path) return answer;
  reply.reachable = true;
  reply.length = path->length;
  reply.points.reserve(path->points.size());
  for (const PathPoint& point : path->points) {
    reply.points.push_back(path_reply_point((*adjacency)->mesh(), point));
  }
  return answer;
}

Result<proto::NearestReply> FieldQueries::nearest(const std::string& mesh,
                                                  const proto::NearestRequest& request,
                                                  const ClientGone& client_gone) {
  const auto adjacency = catalog_.adjacency(mesh, client_gone);
  if (!adjacency) return fail(adjacency.error());
  proto::NearestReply reply;
  reply.mesh = mesh;
  const Resolver resolver(catalog_, mesh, **adjacency, client_gone);
  auto points = resolver.all(request.points, reply.points);
  if (!points) return fail(std::move(points.error()));
  return reply;
}

}  // namespace geodesic::server
