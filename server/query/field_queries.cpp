#include "server/query/field_queries.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/field/around_points.h"
#include "core/field/nearest_copies.h"
#include "core/refine/line_sides.h"
#include "core/steiner/steep_ground.h"
#include "proto/region/weigh_faces.h"
#include "proto/wire/number.h"
#include "proto/wire/query_limits.h"
#include "server/query/landmark_rows.h"
#include "server/query/place.h"

namespace geodesic::server {
namespace {

constexpr double kEverywhere = std::numeric_limits<double>::infinity();

// Whether JSON is to have a float's digits. As a decimal number they may be below it, which an
// upper bound must not be.
bool has_short_digits(const proto::MethodChoice& method) {
  return proto::has_floats(method) && method.options.bound == Bound::none;
}

// A limit that is a float in a float's digits has the vertices that are as far, though the float
// may be above its digits. Nothing else is above what was asked for.
double limit_of(const proto::MethodChoice& method, std::optional<double> max) {
  const double limit = max.value_or(kEverywhere);
  if (!has_short_digits(method) || !(limit < kEverywhere)) return limit;
  const double nearest = as_float(limit);
  std::string digits;
  proto::append_distance(digits, nearest, 0, true);
  return nearest > limit && proto::parse_finite(digits) <= limit ? nearest : limit;
}

// Fills `reached`, `max` and `farthest` from the distances.
void summarise(proto::DistanceReply& reply, Poll& poll) {
  for (std::size_t i = 0; i < reply.distances.size() && !poll.cancelled(); ++i) {
    const double d = reply.distances[i];
    if (d == kUnreached) continue;
    ++reply.reached;
    if (!reply.max || std::abs(d) > *reply.max) {
      reply.max = std::abs(d);
      reply.farthest = i;
    }
  }
}

// Below 0 if it is inside, and not at the line.
double with_sign(double distance, bool is_inside) {
  return is_inside && distance > 0 && distance < kUnreached ? -distance : distance;
}

// Every vertex's distance, and its label if wanted, in source-vertex order. `is_split`: whether
// walls may have doubled vertices. `sides`: null unless distances have a sign. Not all of it if the
// poll says to stop.
void take_whole_field(const Mesh& mesh, const Field& field, bool labels, bool is_split,
                      const LineSides* sides, proto::DistanceReply& reply, Poll& poll) {
  std::vector<std::uint32_t> copies;
  auto vertex_of_source = mesh.vertex_of_source();
  if (is_split) vertex_of_source = copies = nearest_copies(mesh, field.distance, poll);
  reply.distances.reserve(vertex_of_source.size());
  const auto distance_at = [&](std::uint32_t v) {
    return v == kNone ? kUnreached : field.distance[v];
  };
  for (const std::uint32_t v : vertex_of_source) {
    if (poll.cancelled()) return;
    const bool is_inside = sides != nullptr && v != kNone && sides->is_inside(v);
    reply.distances.push_back(with_sign(distance_at(v), is_inside));
  }
  if (!labels) return;
  auto& out = reply.labels.emplace();
  out.reserve(vertex_of_source.size());
  for (const std::uint32_t v : vertex_of_source) {
    if (poll.cancelled()) return;
    const std::uint32_t source =
        field.nearest_source.empty() || v == kNone ? 0 : field.nearest_source[v];
    out.push_back(distance_at(v) == kUnreached ? kNone : field.item_of_source(source));
  }
}

}  // namespace

FieldQueries::FieldQueries(MeshCatalog& catalog, ComputePool& pool, std::uint64_t field_cache_bytes,
                           Metrics& metrics)
    : catalog_(catalog), pool_(pool), fields_(pool, field_cache_bytes, metrics) {}

Result<FieldQueries::Place> FieldQueries::find(const AskedSurface& surface, const Caller& caller) {
  // Preparing is no part of a query's progress: it is mostly done already.
  auto prepared = catalog_.surface(surface, caller.part(0, 0));
  if (!prepared) return fail(std::move(prepared.error()));
  return Place(*this, surface, std::move(*prepared), caller);
}

Result<FieldQueries::Place> FieldQueries::find(const AskedSurface& surface,
                                               const proto::MethodChoice& method,
                                               const Caller& caller) {
  auto place = find(surface, caller);
  if (!place || method.which != Method::steiner) return place;
  const Adjacency& adjacency = *place->adjacency();
  const std::uint64_t nodes =
      adjacency.mesh().vertex_count() + adjacency.report().edges * method.options.points_per_edge;
  if (nodes > proto::kMaxSteinerNodes) {
    return fail_limit(ErrorCode::too_large, "so many points on the edges make too large a graph",
                      proto::kMaxSteinerNodes, nodes, "points_per_edge");
  }
  if (surface.costs().are_lengths()) return place;
  auto cost = cost_of(surface, adjacency.mesh(), caller);
  if (!cost) return fail(std::move(cost.error()));
  const double limit = steepest_resolved(**cost, method.options.points_per_edge);
  double steep = 0;
  if (limit < kEverywhere) {
    const auto part = fields_.compute(
        [&](SolveScratch&, const Cancel& cancel) -> Result<double> {
          Poll poll(cancel);
          const double found = steep_part(adjacency, (*cost)->up(), limit, poll);
          if (poll.stopped()) return fail_stopped(poll);
          return found;
        },
        caller.part(0, 0));
    if (!part) return fail(part.error());
    steep = *part;
  }
  place->set_cost(std::move(*cost));
  place->set_steep_ground(steep, limit, method.options.points_per_edge);
  return place;
}

void FieldQueries::Place::warn_of_steep_ground(std::vector<std::string>& warnings) const {
  constexpr double kMuch = 0.05;
  if (steep_part_ < kMuch) return;
  warnings.push_back(fmt::format(
      "{:.0f} % of this surface is steeper than {:.2g}. With {} points on each edge, costs there "
      "may "
      "be more than {:.0f} % above the least, or no path be found. More points_per_edge come "
      "closer.",
      100 * steep_part_, steep_slope_, points_per_edge_, 100 * kMostAboveLevel));
}

Result<std::shared_ptr<const TravelCost>> FieldQueries::cost_of(const AskedSurface& surface,
                                                                const Mesh& mesh,
                                                                const Caller& caller) {
  const proto::Costs& costs = surface.costs();
  TravelCost::Parts walk = costs.walk;
  if (costs.have_weights()) {
    const auto file = catalog_.file_faces(surface.mesh(), costs.named_of_file(), caller.part(0, 0));
    if (!file) return fail(file.error());
    const auto whole = catalog_.adjacency(surface.mesh(), caller.part(0, 0));
    if (!whole) return fail(whole.error());
    auto weights = fields_.compute(
        [&](SolveScratch&, const Cancel& cancel) {
          return proto::weigh_faces(mesh, (*whole)->mesh(), costs, *file, cancel);
        },
        caller.part(0, 0));
    if (!weights) return fail(std::move(weights.error()));
    walk.weights = std::move(*weights);
  }
  return std::make_shared<const TravelCost>(std::move(walk));
}

Result<std::shared_ptr<const LineSides>> FieldQueries::sides_of(const Adjacency& adjacency,
                                                                const SurfacePolyline& line,
                                                                const Caller& caller) {
  auto sides = fields_.compute(
      [&](SolveScratch&, const Cancel& cancel) {
        return LineSides::find(adjacency, line, proto::kMaxLineVertices, cancel);
      },
      caller.part(0, 0));
  if (sides) return std::make_shared<const LineSides>(std::move(*sides));
  Error error = std::move(sides.error());
  const bool is_of_the_line =
      error.code == ErrorCode::value_out_of_range || error.code == ErrorCode::too_large;
  if (is_of_the_line && error.parameter.empty()) error.parameter = "signed";
  return tl::unexpected(std::move(error));
}

Result<Answered<proto::DistanceReply>> FieldQueries::answer(const AskedSurface& surface,
                                                            const proto::DistanceRequest& request,
                                                            const Caller& caller) {
  const auto place = find(surface, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::DistanceReply> answer;
  answer.adjacency = place->adjacency();
  proto::DistanceReply& reply = answer.reply;
  reply.mesh = surface.mesh();
  reply.method = request.method.which;
  reply.short_digits = has_short_digits(request.method);
  reply.bound = proto::bound_of(request.method);
  if (place->cost()) reply.unit = proto::unit_of(surface.costs());
  SurfacePolyline round;
  place->warn_of_steep_ground(reply.warnings);
  auto sources = place->sources(request.from, reply.from, reply.warnings,
                                request.is_signed ? &round : nullptr);
  if (!sources) return fail(std::move(sources.error()));
  std::shared_ptr<const LineSides> sides;
  if (request.is_signed) {
    auto found = sides_of(*place->adjacency(), round, caller);
    if (!found) return fail(std::move(found.error()));
    sides = std::move(*found);
    reply.is_signed = true;
  }
  const FieldQuestion question{surface.field_key(),
                               place->adjacency(),
                               request.method,
                               std::move(*sources),
                               limit_of(request.method, request.max),
                               place->cost()};

  if (request.at.empty()) {
    const auto field = fields_.whole(question, Details::none, caller);
    if (!field) return fail(field.error());
    answer.cache_hit = field->hit;
    answer.numbers = place->mesh().source_vertex_count() * (request.labels ? 2 : 1);
    const bool is_split = place->refinement() != nullptr;
    if (is_split) answer.drawn_field = field->value;
    if (is_split && sides != nullptr) answer.drawn_inside = {sides, &sides->vertices()};
    answer.complete = [adjacency = place->adjacency(), kept = field->value, labels = request.labels,
                       is_split,
                       sides](proto::DistanceReply& whole, const Cancel& cancel) -> Result<void> {
      Poll poll(cancel);
      take_whole_field(adjacency->mesh(), *kept, labels, is_split, sides.get(), whole, poll);
      summarise(whole, poll);
      if (poll.stopped()) return fail_stopped(poll);
      return {};
    };
  } else {
    const auto at = place->points(request.at, reply.at.emplace(), reply.warnings);
    if (!at) return fail(at.error());
    auto found = fields_.at_points(question, *at, request.labels, caller);
    if (!found) return fail(std::move(found.error()));
    answer.cache_hit = found->hit;
    reply.distances = std::move(found->distances);
    if (request.labels) reply.labels = std::move(found->labels);
    const Cancel cancel(std::cref(caller));
    Poll poll(cancel);
    for (std::size_t i = 0; sides != nullptr && i < at->size() && !poll.cancelled(); ++i) {
      reply.distances[i] = with_sign(reply.distances[i], sides->is_inside((*at)[i], poll));
    }
    summarise(reply, poll);
    if (poll.stopped()) return fail(caller.why_stopped());
  }
  return answer;
}

Result<Answered<proto::TableReply>> FieldQueries::answer(const AskedSurface& surface,
                                                         const proto::TableRequest& request,
                                                         const Caller& caller) {
  const auto place = find(surface, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::TableReply> answer;
  answer.adjacency = place->adjacency();
  proto::TableReply& reply = answer.reply;
  reply.mesh = surface.mesh();
  reply.method = request.method.which;
  reply.short_digits = has_short_digits(request.method);
  reply.bound = proto::bound_of(request.method);
  if (place->cost()) reply.unit = proto::unit_of(surface.costs());
  place->warn_of_steep_ground(reply.warnings);
  const bool has_lines = !is_all_points(request.to.empty() ? request.from : request.to);
  auto rows = place->rows(request.from, reply.rows, reply.warnings, has_lines);
  if (!rows) return fail(std::move(rows.error()));
  auto columns =
      request.to.empty() ? rows : place->rows(request.to, reply.columns, reply.warnings, has_lines);
  if (!columns) return fail(std::move(columns.error()));
  if (request.to.empty()) reply.columns = reply.rows;

  FieldQuestion question{surface.field_key(),
                         place->adjacency(),
                         request.method,
                         {},
                         limit_of(request.method, request.max),
                         place->cost()};
  const std::size_t column_count = columns->size();
  std::vector<SurfacePoint> points = columns->points();
  std::shared_ptr<LineColumns> lines;
  double done = 0;
  bool hit = true;
  Caller rest = caller;  // once it has begun, it is not sent away for the queue's length
  if (has_lines) {
    lines = std::make_shared<LineColumns>(*rows, *columns);
    points = lines->points();
    const double all = static_cast<double>(lines->lines().size() + rows->size());
    if (!request.stream && !request.sparse) {
      done = points.empty() ? 1 : static_cast<double>(lines->lines().size()) / all;
    }
    auto filled = fields_.fill(question, *lines, caller.part(0, done));
    if (!filled) return fail(std::move(filled.error()));
    hit = *filled;
    rest.is_patient = true;
    // Of lines, the entries are all that is needed from here on; a stream would hold them long.
    lines->let_go();
    *columns = FieldRows();
    rows->drop_outlines();
  }
  if (request.stream || request.sparse) {
    auto ready = begin_rows(std::move(question), std::move(*rows), std::move(points),
                            std::move(lines), request.landmarks, rest, answer);
    if (!ready) return fail(std::move(ready.error()));
    return answer;
  }
  PointDistances table;
  if (!points.empty()) {
    auto found = fields_.table(question, *rows, points, rest.part(done, 1));
    if (!found) return fail(std::move(found.error()));
    table = std::move(*found);
    hit = hit && table.hit;
  }
  answer.cache_hit = hit;
  if (!has_lines) {
    reply.distances = std::move(table.distances);
    return answer;
  }
  reply.distances.reserve(rows->size() * column_count);
  for (std::size_t row = 0; row < rows->size(); ++row) {
    const auto whole = lines->whole_row(
        row, std::span(table.distances).subspan(row * points.size(), points.size()));
    reply.distances.insert(reply.distances.end(), whole.begin(), whole.end());
  }
  return answer;
}

Result<void> FieldQueries::begin_rows(FieldQuestion question, FieldRows from,
                                      std::vector<SurfacePoint> to,
                                      std::shared_ptr<const LineColumns> lines,
                                      std::uint64_t landmarks, const Caller& caller,
                                      Answered<proto::TableReply>& answer) {
  auto table = std::make_shared<PointTable>(
      PointTable{std::move(question), std::move(from), std::move(to), {}});
  if (!std::all_of(table->to.begin(), table->to.end(),
                   [](const SurfacePoint& point) { return point.at_vertex(); })) {
    auto faces = in_slot(
        [&](const Cancel& cancel) {
          return faces_around(*table->question.adjacency, table->to, cancel);
        },
        caller.part(0, 0));
    if (!faces) return fail(std::move(faces.error()));
    table->faces = std::move(*faces);
  }
  // Of a table that is estimated, set before the rows begin.
  const auto estimated = std::make_shared<std::shared_ptr<const LandmarkRows>>();
  if (landmarks > 0) {
    answer.bytes_of_estimates =
        LandmarkRows::bytes(landmarks, table->from.size(), table->to.size());
    answer.before_rows = [this, table, landmarks, caller,
                          estimated](proto::TableReply& reply) -> Result<void> {
      auto made =
          LandmarkRows::make(fields_, pool_, table, landmarks, reply.estimated.emplace(), caller);
      if (!made) return fail(std::move(made.error()));
      *estimated = std::move(*made);
      return {};
    };
  }
  answer.rows = [this, table = std::shared_ptr<const PointTable>(table), lines = std::move(lines),
                 estimated,
                 caller](Answered<proto::TableReply>::EncodeRow encode, std::size_t block) {
    auto compute = [this, table, lines, by = *estimated, encode = std::move(encode)](
                       Worker& worker, std::size_t row, const GiveWay& give_way,
                       const Caller& part) -> Result<std::string> {
      std::vector<double> distances;
      if (!table->to.empty()) {
        auto found = by ? by->row(row, worker, give_way, part)
                        : fields_.row(table->question, table->from, row, table->to, table->faces,
                                      worker, give_way, part);
        if (!found) return fail(std::move(found.error()));
        distances = std::move(*found);
      }
      if (lines) distances = lines->whole_row(row, distances);
      return encode(row, distances, Cancel([&] { return give_way() || part(); }));
    };
    Caller asks = caller;
    asks.is_patient = asks.is_patient || *estimated != nullptr;
    return RowsAhead::begin(pool_, table->from.size(), block, std::move(compute), asks);
  };
  return {};
}

Result<Answered<proto::NearestReply>> FieldQueries::answer(const AskedSurface& surface,
                                                           const proto::NearestRequest& request,
                                                           const Caller& caller) {
  const auto place = find(surface, caller);
  if (!place) return fail(place.error());
  Answered<proto::NearestReply> answer;
  answer.adjacency = place->adjacency();
  answer.reply.mesh = surface.mesh();
  const auto points = place->points(request.points, answer.reply.points);
  if (!points) return fail(points.error());
  return answer;
}

}  // namespace geodesic::server
