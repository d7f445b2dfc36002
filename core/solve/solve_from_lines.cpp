#include "core/solve/solve_from_lines.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/base/tolerances.h"
#include "core/curves/strip_front.h"
#include "core/paths/arrive_at_point.h"
#include "core/paths/join_paths.h"
#include "core/paths/path_over_strips.h"
#include "core/straighten/shorten_path.h"

namespace geodesic {
namespace {

// Of methods that are neither exact nor within a tolerance, as `auto` is.
constexpr std::uint64_t kStripsAFace = 8;

// Of the others, on a surface with edges of three faces and more: besides one for each vertex,
// which is the most on any other surface. Measured: 14 on heaps of faces, 250 on a disc of 1000
// thin ones.
constexpr std::uint64_t kMostStripsAFace = 1000;

// A vertex that becomes a source.
void add_source(const Adjacency& adjacency, const MetVertex& met, std::vector<Source>& sources,
                LineWaves& waves) {
  sources.push_back({point_at_vertex(adjacency, met.vertex), met.distance});
  waves.add_item(met.item);
}

// The vertices of faces that are sources, at no distance.
std::vector<MetVertex> vertices_within(const Adjacency& adjacency, const SourceLines& lines,
                                       Poll& poll) {
  std::vector<MetVertex> within;
  if (lines.item_of_face.empty()) return within;
  for (std::uint32_t v = 0; v < adjacency.mesh().vertex_count() && !poll.cancelled(); ++v) {
    for (const std::uint32_t corner : adjacency.corners(v)) {
      const std::uint32_t item = lines.item_of_face[face_of(corner)];
      if (item == kNone) continue;
      within.push_back({v, 0, item});
      break;
    }
  }
  return within;
}

// Of the vertices that strips have met, those with a neighbour to which the way along the edge is
// shorter than by any strip: where straight ways end and others begin. Nothing if stopped.
std::vector<MetVertex> at_shadows(const Adjacency& adjacency, std::span<const MetVertex> met,
                                  Poll& poll) {
  std::vector<MetVertex> result;
  const std::span<const Vec3> positions = adjacency.mesh().positions();
  if (!poll.may_take(positions.size() * sizeof(double) + met.size() * sizeof(MetVertex))) return {};
  std::vector<double> straight(positions.size(), kUnreached);
  for (const MetVertex& v : met) straight[v.vertex] = v.distance;
  result.reserve(met.size());
  const auto is_needed = [&](const MetVertex& v) {
    for (const std::uint32_t corner : adjacency.corners(v.vertex)) {
      if (poll.cancelled()) return false;
      const std::uint32_t c = corner_of(corner);
      for (const std::uint32_t other : {next_corner(c), previous_corner(c)}) {
        const std::uint32_t w = adjacency.tail(halfedge(face_of(corner), other));
        const double by_edge = v.distance + distance(positions[v.vertex], positions[w]);
        if (straight[w] > by_edge * (1 + tolerance::kSameWay)) return true;
      }
    }
    return false;
  };
  for (const MetVertex& v : met) {
    if (is_needed(v)) result.push_back(v);
    if (poll.cancelled()) return {};
  }
  return result;
}

// An upper bound stays one: what rounding may have taken off is added.
double not_below(double distance, double extent) {
  return distance == 0 ? 0 : distance + tolerance::kWindows * (distance + extent);
}

// Takes the vertices into a field of doubles that is done, as sources.
void lower_to(const Adjacency& adjacency, const std::vector<MetVertex>& met, Field& field,
              LineWaves& waves, Poll& poll) {
  if (field.nearest_source.empty()) {
    for (std::size_t v = 0; v < field.distance.size(); ++v) {
      if (poll.cancelled()) return;
      field.nearest_source.push_back(field.distance[v] == kUnreached ? kNone : 0);
    }
  }
  std::vector<double>& distance = field.distance.doubles();
  for (const MetVertex& vertex : met) {
    if (poll.cancelled()) return;
    if (!(vertex.distance < distance[vertex.vertex])) continue;
    distance[vertex.vertex] = vertex.distance;
    field.nearest_source[vertex.vertex] = static_cast<std::uint32_t>(field.sources.size());
    add_source(adjacency, vertex, field.sources, waves);
  }
}

constexpr int kMostSlides = 16;

// The place of the lines that is nearest to where a path leaves the face it begins in, if it is
// nearer than where the path begins.
std::optional<PathPoint> nearer_start(const Adjacency& adjacency, const SourceLines& lines,
                                      const Path& path, Poll& poll) {
  const Mesh& mesh = adjacency.mesh();
  const std::uint32_t face = path.points[0].point.face;
  const Vec3 to = path.points[1].position;
  double least = distance(path.points[0].position, to) * (1 - tolerance::kSameWay);
  std::optional<PathPoint> nearer;
  for (const LineSegment& segment : lines.segments) {
    if (poll.cancelled()) return std::nullopt;
    if (segment.face != face) continue;
    const Vec3 from = position_of(mesh, {face, segment.from, kNone});
    const Vec3 along = position_of(mesh, {face, segment.to, kNone}) - from;
    const double square = dot(along, along);
    const double part = square > 0 ? std::clamp(dot(to - from, along) / square, 0.0, 1.0) : 0;
    std::array<double, 3> bary{};
    for (std::uint32_t c = 0; c < 3; ++c) {
      bary[c] = segment.from[c] + part * (segment.to[c] - segment.from[c]);
    }
    const SurfacePoint point = point_on_face(adjacency, face, bary);
    const Vec3 position = position_of(mesh, point);
    if (!(distance(position, to) < least)) continue;
    least = distance(position, to);
    nearer = PathPoint{point, position};
  }
  return nearer;
}

// Makes a path locally shortest that may bend where its first leg ends: pulls it straight, and
// moves its start to the nearest place of the lines in its first face, by turns, until that gains
// nothing.
Result<std::optional<Path>> straightened(const Adjacency& adjacency, const SourceLines& lines,
                                         Path path, const Cancel& cancel) {
  Poll poll(cancel);
  for (int slides = 0;; ++slides) {
    auto shorter = shorten_path(adjacency, path, cancel);
    if (!shorter) return fail(std::move(shorter.error()));
    path = std::move(*shorter);
    if (slides == kMostSlides || path.points.size() < 2) return path;
    const std::optional<PathPoint> start = nearer_start(adjacency, lines, path, poll);
    if (poll.stopped()) return fail_stopped(poll);
    if (!start) return path;
    const Vec3 to = path.points[1].position;
    path.length += distance(start->position, to) - distance(path.points[0].position, to);
    path.points[0] = *start;
  }
}

}  // namespace

Result<Field> solve_from_lines(Method method, const MethodOptions& options,
                               const Adjacency& adjacency, std::span<const Source> sources,
                               std::shared_ptr<const SourceLines> lines, const FieldLimits& limits,
                               SolveScratch& scratch, const Cancel& cancel) {
  const MethodTraits traits = traits_of(method);
  StripLimits strips;
  strips.max = limits.max;
  strips.keep_strips = limits.keep_details;
  MethodOptions taken = options;
  if (method == Method::back_traced && !options.error_at_most)
    taken.error_at_most = kToleranceFromLines;
  if (!traits.has_windows && !taken.error_at_most) {
    strips.most = kStripsAFace * adjacency.faces().size();
  } else if (adjacency.report().edges_non_manifold > 0) {
    strips.most = (kMostStripsAFace + adjacency.mesh().vertex_count()) * adjacency.faces().size();
    strips.fail_beyond = true;
  }
  constexpr double kStripsPart = 0.5;
  auto spread = spread_strips(adjacency, sources, lines, strips, cancel.part(0, kStripsPart));
  if (!spread) return fail(std::move(spread.error()));
  cancel.report(kStripsPart);

  Poll poll(cancel);
  LineWaves& waves = *spread->waves;
  std::vector<MetVertex> within = vertices_within(adjacency, *lines, poll);
  const bool is_bound = options.bound == Bound::upper || options.error_at_most;
  const Box& box = adjacency.mesh().box();
  const double extent = norm(box.max - box.min);
  const std::uint64_t most = sources.size() + spread->met.size() + within.size();
  if (!poll.may_take(2 * most * sizeof(Source))) return fail_stopped(poll);
  std::vector<Source> all(sources.begin(), sources.end());
  for (MetVertex& met : spread->met) {
    if (poll.cancelled()) return fail_stopped(poll);
    if (is_bound) met.distance = not_below(met.distance, extent);
  }
  // Past most of them strips go on as well. That counts where a source has a wave of its own.
  std::vector<MetVertex> few;
  if (traits.has_wave_for_each_source) {
    few = at_shadows(adjacency, spread->met, poll);
    if (poll.stopped()) return fail_stopped(poll);
  }
  const std::vector<MetVertex>& going_on = traits.has_wave_for_each_source ? few : spread->met;
  // Along a graph it is no farther to a vertex than by way of its neighbour, whichever that is.
  const bool is_along_graph = traits.are_metric && !traits.has_windows;
  for (const MetVertex& met : going_on) {
    if (poll.cancelled()) return fail_stopped(poll);
    // Where strips have ended for there were too many, their vertices go on as points.
    if (is_along_graph || !spread->is_complete || may_bend(adjacency, met.vertex, poll)) {
      add_source(adjacency, met, all, waves);
    }
  }
  FieldLimits whole = limits;
  whole.targets = {};
  whole.detour = {};
  whole.may_keep_refined = false;
  auto field =
      solve_field(method, taken, adjacency, all, whole, scratch, cancel.part(kStripsPart, 1));
  if (!field) return field;
  field->bound = is_bound ? Bound::upper : Bound::none;
  lower_to(adjacency, spread->met, *field, waves, poll);
  lower_to(adjacency, within, *field, waves, poll);
  if (poll.stopped()) return fail_stopped(poll);
  field->count_reached();
  field->lines = std::move(spread->waves);
  return field;
}

Result<std::optional<Path>> path_from_lines(const Adjacency& adjacency, const Field& field,
                                            const SurfacePoint& target, PathWork work,
                                            const Cancel& cancel) {
  if (!field.lines) return path_through(adjacency, field, target, work, cancel);
  Poll poll(cancel);
  const PointArrivals arrivals(adjacency, field, &poll);
  const double round = arrivals.distance_at(target);
  const LineArrival straight = field.lines->arrive(adjacency, target, &poll);
  if (poll.stopped()) return fail_stopped(poll);
  if (straight.distance < kUnreached && straight.distance <= round * (1 + tolerance::kSameWay)) {
    return path_over_strips(adjacency, *field.lines, straight, poll);
  }
  auto path = path_through(adjacency, field, target, work, cancel);
  if (!path || !*path) return path;
  // Where windows say that a path bends, a shortest one does.
  const bool may_be_bent = work == PathWork::refined && !field.windows;
  const SourceLines& lines = field.lines->lines();
  const std::uint32_t source = (*path)->source;
  if (source < field.lines->given()) {
    return may_be_bent ? straightened(adjacency, lines, std::move(**path), cancel)
                       : std::move(path);
  }
  const SurfacePoint& bend = field.sources[source].point;
  const LineArrival start = field.lines->arrive(adjacency, bend, &poll);
  if (poll.stopped()) return fail_stopped(poll);
  if (start.distance == kUnreached) return path;
  auto first = path_over_strips(adjacency, *field.lines, start, poll);
  if (!first || !*first) return first;
  const std::array<Path, 2> both{std::move(**first), std::move(**path)};
  Path joined = join_paths(both);
  if (!may_be_bent) return std::optional(std::move(joined));
  return straightened(adjacency, lines, std::move(joined), cancel);
}

}  // namespace geodesic
