#include "server/query/fields.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string_view>

#include "core/field/around_points.h"
#include "core/field/longest_edge.h"
#include "core/paths/arrive_at_point.h"
#include "core/paths/trace_path.h"
#include "core/solve/distance_at_point.h"
#include "core/solve/exact_pair.h"
#include "core/solve/scratch_parts.h"
#include "core/solve/solve_from_lines.h"
#include "core/steiner/cheapest_way.h"
#include "core/steiner/steiner.h"
#include "proto/wire/number.h"
#include "server/base/joint_caller.h"
#include "server/base/sha256.h"
#include "server/base/timed.h"
#include "server/places/read_line.h"

namespace geodesic::server {
namespace {

// Whether what is kept for points inside faces is of the faces of these points alone: then a
// field that is kept for others is of no use. All windows of such a field take as much memory as
// those of `exact`. From lines, `auto` goes by windows without a tolerance, too.
bool is_for_points_alone(const FieldQuestion& question, Details details) {
  return details == Details::kept && question.method.which == Method::back_traced &&
         (question.method.options.error_at_most.has_value() || question.from.lines);
}

// The question spelt out; two spellings of one point are one key.
std::string spelt_out(const FieldQuestion& question, Details details) {
  std::string key = question.surface + "/" + proto::field_key(question.method) + "/";
  // Fields from lines have their strips besides, by any method.
  // That of `auto` may have windows on a machine part.
  const bool has_details =
      question.from.lines || traits_of(question.method.which).has_details() ||
      (question.method.which == Method::back_traced &&
       (question.adjacency->refined() != nullptr || question.adjacency->has_large_faces()));
  if (details == Details::kept && has_details) key += "details/";
  proto::append_number(key, question.max);
  if (question.from.lines) return key + "/lines-" + question.from.key;
  for (const Source& source : question.from.points) {
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

// What the cache knows a field by. A long question is known by its digest, lest keys, which the
// cache does not count, take more memory than fields. What it begins with stays: a mesh's fields
// are forgotten by that.
std::string key_of(const FieldQuestion& question, Details details) {
  constexpr std::size_t kLongestKey = 512;
  std::string key = spelt_out(question, details);
  if (key.size() <= kLongestKey) return key;
  const std::size_t begin = question.surface.size() + 1;
  key.replace(begin, std::string::npos, sha256_hex(std::string_view(key).substr(begin)));
  return key;
}

Details details_for(std::span<const SurfacePoint> points) {
  const bool at_vertices = std::all_of(points.begin(), points.end(),
                                       [](const SurfacePoint& point) { return point.at_vertex(); });
  return at_vertices ? Details::none : Details::kept;
}

// The number of the source that a point's distance is from; kNone where there is none.
Result<std::uint32_t> label_at(const Adjacency& adjacency, const Field& field,
                               const SurfacePoint& point, double distance, const Cancel& cancel) {
  if (distance == kUnreached) return kNone;
  if (field.nearest_source.empty()) return field.item_of_source(0);
  if (point.at_vertex()) return field.item_of_source(field.nearest_source[point.vertex]);
  if (field.lines) {
    Poll poll(cancel);
    const LineArrival straight = field.lines->arrive(adjacency, point, &poll);
    if (poll.stopped()) return fail_stopped(poll);
    if (straight.distance <= distance) return field.lines->item_of(straight);
  }
  // Inside a face, where several sources may meet: where its path leads.
  auto path = trace_path(adjacency, field, point, cancel);
  if (!path) return fail(std::move(path.error()));
  return *path ? field.item_of_source((*path)->source) : kNone;
}

// What a field of costs says of the points, as far as `max`.
PointDistances read_costs(const Adjacency& adjacency, const Field& field, double max,
                          std::span<const SurfacePoint> points, bool labels, Poll& poll) {
  PointDistances result;
  const CheapestWays ways(adjacency, field, poll);
  result.distances.reserve(points.size());
  for (const SurfacePoint& point : points) {
    if (poll.cancelled()) break;
    const CheapestWays::LastStep last = ways.last_step_to(point);
    const bool is_within = last.cost <= max && last.source != kNone;
    result.distances.push_back(is_within ? last.cost : kUnreached);
    if (labels) result.labels.push_back(is_within ? last.source : kNone);
  }
  return result;
}

// What the field of a question says of the points, as far as its `max`.
Result<PointDistances> read_field(const FieldQuestion& question, const Field& field,
                                  std::span<const SurfacePoint> points, bool labels,
                                  const Cancel& cancel) {
  const Adjacency& adjacency = *question.adjacency;
  const double max = question.max;
  PointDistances result;
  Poll poll(cancel, 256);
  if (question.cost != nullptr) {
    result = read_costs(adjacency, field, max, points, labels, poll);
    if (poll.stopped()) return fail_stopped(cancel);
    return result;
  }
  const PointArrivals arrivals(adjacency, field, &poll);
  result.distances.reserve(points.size());
  for (const SurfacePoint& point : points) {
    const auto found = distance_at_point(adjacency, field, arrivals, point, cancel);
    if (!found) return fail(found.error());
    if (poll.cancelled()) return fail_stopped(cancel);
    const double distance = within(max, *found);
    result.distances.push_back(distance);
    if (!labels) continue;
    auto label = label_at(adjacency, field, point, distance, cancel);
    if (!label) return fail(std::move(label.error()));
    result.labels.push_back(*label);
  }
  return result;
}

// Whether there can be anything in a search: below so many vertices a whole field takes
// a few milliseconds.
constexpr std::uint32_t kManyVertices = 5000;

bool can_be_searched(const FieldQuestion& question) {
  return question.from.points.size() == 1 && !question.from.lines &&
         searches_pairs(question.method.which) &&
         question.adjacency->mesh().vertex_count() >= kManyVertices;
}

bool can_be_helped(const FieldQuestion& question) {
  return geodesic::can_be_helped(question.method.which, question.method.options,
                                 *question.adjacency, question.from.points);
}

// How far a field goes, so that points inside faces as far away as `max` have what they are told
// by: their corners may be farther.
double max_around(const FieldQuestion& question, std::span<const std::uint32_t> faces) {
  if (question.cost || faces.empty()) return question.max;
  return question.max + longest_edge_of(*question.adjacency, faces);
}

// So many searches take less than a field that stops at the last of the targets.
constexpr std::size_t kFewTargets = 2;

}  // namespace

Fields::Fields(ComputePool& pool, std::uint64_t cache_bytes, Metrics& metrics)
    : pool_(pool),
      metrics_(metrics),
      cache_(cache_bytes, [](const Field& field) { return field.bytes(); }),
      scratch_(pool.slots()) {
  pool_.observe_want_of_room([this](Worker& worker) { scratch_[worker.slot] = KeptScratch(); });
}

Fields::~Fields() { pool_.observe_want_of_room({}); }

Result<Field> Fields::solve(const FieldQuestion& question, const FieldLimits& limits,
                            SolveScratch& scratch, const Cancel& cancel, const Caller& caller) {
  const Timed timed(caller, Stage::solve);
  if (question.cost) {
    auto costs = steiner_field(*question.adjacency, question.from.points,
                               question.method.options.points_per_edge, limits,
                               scratch.parts().wavefront, cancel, question.cost);
    metrics_.solved(proto::name_of(question.method.which), timed.so_far().count());
    return costs;
  }
  ComputePool::Help help(pool_, can_be_helped(question));
  const Cancel helped = cancel.helped_by(help.team());
  auto field =
      question.from.lines
          ? solve_from_lines(question.method.which, question.method.options, *question.adjacency,
                             question.from.points, question.from.lines, limits, scratch, helped)
          : solve_field(question.method.which, question.method.options, *question.adjacency,
                        question.from.points, limits, scratch, helped);
  metrics_.solved(proto::name_of(question.method.which), timed.so_far().count());
  return field;
}

Result<LruCache<Field>::Lookup> Fields::whole(const FieldQuestion& question, Details details,
                                              const Caller& caller) {
  return cache_.get_or_create(
      key_of(question, details),
      [&]() -> Result<std::shared_ptr<const Field>> {
        FieldLimits limits;
        limits.max = question.max;
        limits.keep_details = details == Details::kept;
        limits.may_keep_refined = true;
        auto field = compute(
            [&](SolveScratch& scratch, const Cancel& cancel) {
              return solve(question, limits, scratch, cancel, caller);
            },
            caller);
        if (!field) return fail(std::move(field.error()));
        return std::make_shared<const Field>(std::move(*field));
      },
      caller);
}

bool Fields::is_to_be_searched(const FieldQuestion& question, Details details) {
  if (!can_be_searched(question)) return false;
  if (is_for_points_alone(question, details)) return true;
  if (details == Details::kept && question.method.which == Method::exact &&
      question.adjacency->mesh().vertex_count() > kManyForWindows) {
    return true;
  }
  const std::string key = key_of(question, details);
  return asked_.is_first(key) && cache_.find(key) == nullptr;
}

Result<Pair> Fields::search(const FieldQuestion& question, const SurfacePoint& to, PairPath path,
                            SolveScratch& scratch, const Cancel& cancel, const Caller& caller) {
  const Timed timed(caller, Stage::search);
  // By other methods it is soon done.
  ComputePool::Help help(pool_, question.method.which == Method::exact && can_be_helped(question));
  return pair_search(question.method.which, question.method.options, *question.adjacency,
                     question.from.points.front(), to, path, scratch,
                     cancel.helped_by(help.team()));
}

Result<PointDistances> Fields::at_points(const FieldQuestion& question,
                                         std::span<const SurfacePoint> points, bool labels,
                                         const Caller& caller) {
  // Fields from lines and of costs are whole, however few points are asked for.
  const bool is_whole = (question.from.lines != nullptr || question.cost != nullptr) &&
                        !is_for_points_alone(question, details_for(points));
  if (is_whole || (points.size() == 1 && can_be_searched(question))) {
    const Details details = details_for(points);
    if (is_whole || !is_to_be_searched(question, details)) {
      FieldQuestion farther = question;
      if (details == Details::kept && question.max != kUnreached) {
        const auto faces = faces_around(*question.adjacency, points, Cancel(std::cref(caller)));
        if (!faces) return fail(faces.error());
        farther.max = max_around(question, *faces);
      }
      const auto field = whole(farther, details, caller);
      if (!field) return fail(field.error());
      auto read = compute(
          [&](SolveScratch&, const Cancel& cancel) {
            return read_field(question, *field->value, points, labels, cancel);
          },
          field->hit ? caller : caller.finishing());
      if (read) read->hit = field->hit;
      return read;
    }
  }
  return compute(
      [&](SolveScratch& scratch, const Cancel& cancel) -> Result<PointDistances> {
        const auto targets = vertices_around(*question.adjacency, points, cancel);
        if (!targets) return fail(targets.error());
        return read_points(question, points, *targets, labels, scratch, cancel, caller);
      },
      caller);
}

Result<PointDistances> Fields::table(const FieldQuestion& question, const FieldRows& from,
                                     std::span<const SurfacePoint> to, const Caller& caller) {
  const Adjacency& adjacency = *question.adjacency;
  const auto targets =
      details_for(to) == Details::none
          ? vertices_around(adjacency, to, Cancel())
          : compute([&](SolveScratch&,
                        const Cancel& cancel) { return vertices_around(adjacency, to, cancel); },
                    caller.part(0, 0));
  if (!targets) return fail(targets.error());
  PointDistances table;
  table.hit = true;
  table.distances.resize(from.size() * to.size());
  JointCaller joint(caller, from.size());
  const auto compute_row = [&](Worker& worker, std::size_t row,
                               const GiveWay& give_way) -> Result<void> {
    JointCaller::Part part(joint, row);
    const auto read = [&](SolveScratch& scratch, const Cancel& cancel) -> Result<PointDistances> {
      auto sources = from.of(row, scratch, cancel.part(0, 0));
      if (!sources) return fail(std::move(sources.error()));
      FieldQuestion own = question;
      own.from = std::move(*sources);
      return read_points(own, to, *targets, false, scratch, cancel, part.caller());
    };
    auto found = run_part(read, worker, give_way, part.caller());
    if (!found) return fail(std::move(found.error()));
    std::copy(found->distances.begin(), found->distances.end(),
              table.distances.begin() + static_cast<std::ptrdiff_t>(row * to.size()));
    part.done(found->hit);
    return {};
  };
  if (auto all = pool_.run_each(from.size(), compute_row, caller); !all) {
    return fail(std::move(all.error()));
  }
  table.hit = joint.all_hit();
  return table;
}

Result<bool> Fields::fill(const FieldQuestion& question, LineColumns& lines, const Caller& caller) {
  JointCaller joint(caller, lines.lines().size());
  const auto compute_line = [&](Worker& worker, std::size_t number,
                                const GiveWay& give_way) -> Result<void> {
    JointCaller::Part part(joint, number);
    const auto fill_one = [&](SolveScratch& scratch, const Cancel& cancel) {
      return fill_from(question, number, lines, scratch, cancel, part.caller());
    };
    const auto hit = run_part(fill_one, worker, give_way, part.caller());
    if (!hit) return fail(hit.error());
    part.done(*hit);
    return {};
  };
  if (auto all = pool_.run_each(lines.lines().size(), compute_line, caller); !all) {
    return fail(std::move(all.error()));
  }
  return joint.all_hit();
}

Result<bool> Fields::fill_from(const FieldQuestion& question, std::size_t number,
                               LineColumns& lines, SolveScratch& scratch, const Cancel& cancel,
                               const Caller& caller) {
  const LineColumns::Line& line = lines.lines()[number];
  const Adjacency& adjacency = *question.adjacency;
  const auto asked = asked_of(adjacency, lines, number, cancel);
  if (!asked) return fail(asked.error());
  if (asked->is_nothing()) return true;
  auto sources = line.in->of(line.number, scratch, cancel.part(0, 0));
  if (!sources) return fail(std::move(sources.error()));
  FieldQuestion own = question;
  own.from = std::move(*sources);
  FieldLimits limits;
  limits.max = own.max;
  bool hit = true;
  // As the field of the vertices alone has them, whatever other rows there are.
  if (!asked->at_vertices.empty()) {
    std::shared_ptr<const Field> field = cache_.find(key_of(own, Details::none));
    hit = field != nullptr;
    limits.keep_details = false;
    if (!hit) {
      auto solved = solve(own, limits, scratch, cancel, caller);
      if (!solved) return fail(std::move(solved.error()));
      field = std::make_shared<const Field>(std::move(*solved));
    }
    for (const std::uint32_t row : asked->at_vertices) {
      lines.put(line, row, within(own.max, field->distance[lines.point(row).vertex]));
    }
  }
  if (asked->faces.empty()) return hit;
  limits.keep_details = true;
  limits.detail_faces = asked->faces;
  limits.max = max_around(own, asked->faces);
  const auto field = solve(own, limits, scratch, cancel, caller);
  if (!field) return fail(field.error());
  auto put = put_within(adjacency, *field, own.max, *asked, line, lines, cancel);
  if (!put) return fail(std::move(put.error()));
  return false;
}

Result<std::vector<double>> Fields::row(const FieldQuestion& question, const FieldRows& from,
                                        std::size_t number, std::span<const SurfacePoint> points,
                                        std::span<const std::uint32_t> faces, Worker& worker,
                                        const GiveWay& give_way, const Caller& caller) {
  const auto read = [&](SolveScratch& scratch,
                        const Cancel& cancel) -> Result<std::vector<double>> {
    return read_row(question, from, number, points, faces, scratch, cancel, caller);
  };
  return run_part(read, worker, give_way, caller);
}

Result<std::vector<double>> Fields::read_row(const FieldQuestion& question, const FieldRows& from,
                                             std::size_t number,
                                             std::span<const SurfacePoint> points,
                                             std::span<const std::uint32_t> faces,
                                             SolveScratch& scratch, const Cancel& cancel,
                                             const Caller& caller) {
  auto sources = from.of(number, scratch, cancel.part(0, 0));
  if (!sources) return fail(std::move(sources.error()));
  FieldQuestion own = question;
  own.from = std::move(*sources);
  // What is kept for points inside faces may be of the faces of others alone: not to be relied on.
  const Details details = faces.empty() ? Details::none : Details::kept;
  std::shared_ptr<const Field> field;
  if (details == Details::none) field = cache_.find(key_of(own, details));
  if (!field) {
    FieldLimits limits;
    limits.max = max_around(own, faces);
    limits.keep_details = details == Details::kept;
    limits.detail_faces = faces;
    limits.may_keep_refined = true;
    auto solved = solve(own, limits, scratch, cancel, caller);
    if (!solved) return fail(std::move(solved.error()));
    field = std::make_shared<const Field>(std::move(*solved));
  }
  auto read = read_field(own, *field, points, false, cancel);
  if (!read) return fail(std::move(read.error()));
  return std::move(read->distances);
}

Result<PointDistances> Fields::read_points(const FieldQuestion& question,
                                           std::span<const SurfacePoint> points,
                                           std::span<const std::uint32_t> targets, bool labels,
                                           SolveScratch& scratch, const Cancel& cancel,
                                           const Caller& caller) {
  const Details details = details_for(points);
  std::shared_ptr<const Field> field;
  if (!is_for_points_alone(question, details)) field = cache_.find(key_of(question, details));
  const bool hit = field != nullptr;
  if (!field && points.size() <= kFewTargets && can_be_searched(question)) {
    return search_points(question, points, scratch, cancel, caller);
  }
  if (!field) {
    FieldLimits limits;
    limits.max = question.max;
    // A cheap way may come to a point of a face after all of its corners.
    if (!question.cost) limits.targets = targets;
    limits.keep_details = details == Details::kept;
    limits.may_keep_refined = true;
    const auto faces = faces_around(*question.adjacency, points, cancel);
    if (!faces) return fail(faces.error());
    limits.beyond_targets = longest_edge_of(*question.adjacency, *faces);
    limits.max = max_around(question, *faces);
    // A label may be at the end of a path, over any of the faces.
    const bool by_path = labels && !is_for_points_alone(question, details);
    if (!by_path) limits.detail_faces = *faces;
    auto part = solve(question, limits, scratch, cancel, caller);
    if (!part) return fail(std::move(part.error()));
    field = std::make_shared<const Field>(std::move(*part));
  }
  auto result = read_field(question, *field, points, labels, cancel);
  if (result) result->hit = hit;
  return result;
}

Result<PointDistances> Fields::search_points(const FieldQuestion& question,
                                             std::span<const SurfacePoint> points,
                                             SolveScratch& scratch, const Cancel& cancel,
                                             const Caller& caller) {
  PointDistances result;
  for (const SurfacePoint& point : points) {
    const auto pair = search(question, point, PairPath::none, scratch, cancel, caller);
    if (!pair) return fail(pair.error());
    const bool is_within = pair->distance <= question.max;
    result.distances.push_back(is_within ? pair->distance : kUnreached);
    result.labels.push_back(result.distances.back() < kUnreached ? 0 : kNone);
  }
  return result;
}

}  // namespace geodesic::server
