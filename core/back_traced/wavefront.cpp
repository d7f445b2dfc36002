#include "core/back_traced/wavefront.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/back_traced/front.h"
#include "core/back_traced/relax_edges.h"
#include "core/base/team.h"
#include "core/base/tolerances.h"
#include "core/field/straight_floor.h"
#include "core/field/vertex_front.h"
#include "core/wavefront/edge_dijkstra.h"
#include "core/wavefront/waves.h"

namespace geodesic {
namespace {

// Coarse meshes bend more from vertex to vertex than fine ones of the same shape, and small ones
// are soon done however far traces go.
bool looks_deep(const Adjacency& adjacency) {
  constexpr std::uint32_t kFewVertices = 20'000;
  return adjacency.is_rough() || adjacency.mesh().vertex_count() <= kFewVertices;
}

// The farthest that a field with these limits goes.
double reach(const FieldLimits& limits, const Field& field) {
  double max = limits.max;
  if (!limits.targets.empty()) {
    double farthest = 0;
    for (const std::uint32_t v : limits.targets) farthest = std::max(farthest, field.distance[v]);
    max = std::min(max, farthest);
  }
  return max;
}

// Those that `from` has; of bounds the lesser ones. Tells which.
template <class Taken>
void take_distances(const Field& from, Bound bound, Field& field, Taken taken) {
  const std::span<double> distance = field.distance.doubles();
  for (std::size_t v = 0; v < distance.size(); ++v) {
    const double other = from.distance[v];
    if (other == kUnreached || (bound == Bound::upper && !(other < distance[v]))) continue;
    distance[v] = other;
    taken(static_cast<std::uint32_t>(v));
    if (!field.nearest_source.empty()) field.nearest_source[v] = from.nearest_source[v];
  }
}

// Which of how many waves of the query, for its progress.
struct WaveNumber {
  std::uint32_t number;
  std::size_t of;
};

// Where a wave ends.
struct WaveEnds {
  double max;  // of several sources with the offsets, of one without its own
  const Detour& detour;
  RemainingTargets& targets;
  // Of several sources, the targets again. When all have a distance, a nearer source may still
  // come: so the wave goes on until it is beyond the farthest of them.
  std::span<const std::uint32_t> to_be_sure_of = {};
};

// Runs a wave, as detail::run_wave does for fronts that accept one vertex after another.
template <class Accepted>
Result<void> run_wave(BackTracedFront& front, const Adjacency& adjacency,
                      std::span<const Source> sources, WaveNumber wave,
                      const detail::OtherSources& others, WaveEnds ends, bool is_each_told,
                      Poll& poll, Accepted accepted) {
  const detail::Worthwhile worthwhile(adjacency, sources[0], others, ends.detour);
  const bool goes_everywhere = others.earlier.empty() && !ends.detour.is_bounded();
  front.start(sources, worthwhile);
  double last = ends.max < kUnreached ? ends.max + front.lag() : ends.max;
  bool is_last_known = false;
  const auto is_done = [&] {
    if (is_last_known || !ends.targets.done() || front.may_improve()) return false;
    if (ends.to_be_sure_of.empty()) return true;
    double farthest = 0;
    for (const std::uint32_t v : ends.to_be_sure_of) {
      farthest = std::max(farthest, front.least_distance(v));
    }
    last = std::min(last, farthest + front.lag());
    is_last_known = true;
    return false;
  };
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  // As if each wave came to every vertex.
  const std::uint64_t total = wave.of * vertex_count;
  std::uint64_t done = wave.number * vertex_count;
  bool cancelled = false;
  while (!is_done() && !cancelled && front.accept_next(last)) {
    if (poll.stopped()) break;
    const std::size_t count = front.accepted_count();
    cancelled = poll.cancelled_after(count, std::min(done, total), total);
    done += count;
    if (is_each_told) {
      front.for_each_accepted([&](std::uint32_t v) {
        ends.targets.accept(v);
        accepted(v);
      });
    }
    if (!goes_everywhere) {
      front.stop_where([&](std::uint32_t v, double distance) { return !worthwhile(v, distance); });
    }
    front.spread();
  }
  front.end();
  if (cancelled || poll.stopped()) return fail_stopped(poll);
  return {};
}

// Takes the least distance of each vertex, of equal ones that from the first source. Each is raised
// to the straight line from its source before, for what is too low would win. Returns whether any
// was below that by more than rounding.
bool take_nearest(const Mesh& mesh, const BackTracedScratch& scratch, Field& field, Poll& poll) {
  std::vector<StraightLinesFrom> lines;
  for (const Source& source : field.sources) lines.emplace_back(mesh, source.point);
  const std::uint32_t vertex_count = mesh.vertex_count();
  field.nearest_source.assign(vertex_count, kNone);
  const std::span<double> distance = field.distance.doubles();
  bool is_any_below = false;
  for (std::uint32_t v = 0; v < vertex_count && !poll.cancelled(); ++v) {
    for (Slot slot = v; slot != kNone; slot = scratch.slots.next[slot]) {
      const std::uint32_t source = scratch.slots.source[slot];
      if (source == kNone) continue;
      double found = scratch.distance[slot];
      is_any_below = lines[source].raise(mesh.positions()[v], found) || is_any_below;
      found += field.sources[source].offset;
      if (!(found < kUnreached)) continue;
      if (std::pair(found, source) < std::pair(distance[v], field.nearest_source[v])) {
        distance[v] = found;
        field.nearest_source[v] = source;
      }
    }
  }
  return is_any_below;
}

// What a query computes with.
struct Query {
  const Adjacency& adjacency;
  std::span<const Source> sources;
  const FieldLimits& limits;
  BackTrace::Rule rule;
  BackTracedScratch& scratch;
};

// Of one source. Where those reached are listed, all that was touched is in scratch.visited.
Result<void> go_from_one(const Query& query, bool is_listed, Field& field, Poll& poll) {
  const auto& [adjacency, sources, limits, rule, scratch] = query;
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  VertexSet& visited = scratch.visited;
  const auto visit = [&visited, is_listed](std::uint32_t v) {
    if (is_listed) visited.insert(v);
  };
  BackTracedFront front(
      adjacency, rule, scratch, field.distance.doubles(),
      is_listed || poll.team() == nullptr ? 1 : poll.team()->parts_for(vertex_count), poll);
  RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
  const double offset = sources[0].offset;
  auto wave =
      run_wave(front, adjacency, sources, {0, 1}, {}, {limits.max - offset, limits.detour, targets},
               is_listed || !limits.targets.empty(), poll, visit);
  if (!wave) return wave;
  if (offset != 0) {
    for (double& d : field.distance.doubles()) d += offset;
  }
  return {};
}

// Of several sources in one wave. `is_any_below`: whether a distance was below the straight line.
Result<void> go_from_several(const Query& query, Field& field, bool& is_any_below, Poll& poll) {
  const auto& [adjacency, sources, limits, rule, scratch] = query;
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  const Detour anywhere;
  BackTracedFront front(adjacency, rule, scratch, poll);
  RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
  auto wave = run_wave(front, adjacency, sources, {0, 1}, {},
                       {limits.max, anywhere, targets, limits.targets}, !limits.targets.empty(),
                       poll, [](std::uint32_t) {});
  if (!wave) return wave;
  is_any_below = take_nearest(adjacency.mesh(), scratch, field, poll);
  return {};
}

// Of several sources in a wave each.
Result<void> go_from_each(const Query& query, std::span<const double> along_edges, Field& field,
                          bool& is_any_below, Poll& poll) {
  const auto& [adjacency, sources, limits, rule, scratch] = query;
  scratch.distance.assign(adjacency.mesh().vertex_count(), kUnreached);
  const Detour anywhere;
  std::vector<std::uint32_t> reached;
  BackTracedFront front(adjacency, rule, scratch, scratch.distance, 1, poll);
  const auto run = [&](std::uint32_t s, double max, RemainingTargets& targets, auto accepted) {
    reached.clear();
    const std::span<const Source> source(&query.sources[s], 1);
    auto wave =
        run_wave(front, query.adjacency, source, {s, query.sources.size()},
                 {field.distance.doubles(), along_edges},
                 {max - source[0].offset, anywhere, targets}, true, poll, [&](std::uint32_t v) {
                   reached.push_back(v);
                   accepted(v);
                 });
    is_any_below = raise_to_straight_lines(query.adjacency.mesh(), source[0].point, reached,
                                           query.scratch.distance, poll) ||
                   is_any_below;
    return wave;
  };
  return detail::run_waves(front, limits, field, scratch.is_target, run,
                           [&](std::uint32_t v) { front.forget(v); });
}

}  // namespace

Result<Field> back_traced_field(const Adjacency& adjacency, std::span<const Source> sources,
                                const FieldLimits& asked, Bound bound, const Field* near,
                                BackTracedScratch& scratch, const Cancel& cancel) {
  FieldLimits limits = asked;
  limits.max *= 1 + tolerance::kSinglePrecision;
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field = unreached_field(Method::back_traced, sources, vertex_count);
  // Of an edge in very many faces a front knows the nearest to one source (crowded_edges.h). So on
  // such a mesh each source has a front.
  const bool is_one_front = sources.size() > 1 && !adjacency.delaunay().is_crowded;
  if (!scratch.is_clean || scratch.vertices.size() < vertex_count) {
    scratch.vertices.assign(vertex_count, {});
  }
  scratch.is_clean = false;
  // A search for a pair, and a field that ends nearby, cost what they go over, not what the mesh
  // has.
  const bool is_search = sources.size() == 1 && limits.detour.is_bounded();
  const bool is_listed = is_search || (sources.size() == 1 && limits.max < kUnreached);
  VertexSet& visited = scratch.visited;
  if (is_listed) visited.reset(vertex_count);
  const BackTrace::Rule rule{
      bound == Bound::upper ? BackTrace::Candidates::paths : BackTrace::Candidates::virtual_sources,
      looks_deep(adjacency) ? BackTrace::Depth::deep : BackTrace::Depth::usual};
  auto along_edges = Result<std::vector<double>>();
  if (sources.size() > 1 && !is_one_front) {
    along_edges = detail::ways_along_edges(adjacency, sources, limits.max, cancel);
  }
  if (!along_edges) return fail(along_edges.error());
  const Cancel rest = detail::after_ways_along_edges(*along_edges, cancel);
  Poll poll(rest);
  bool is_any_below = false;
  const Query query{adjacency, sources, limits, rule, scratch};
  const auto gone = sources.size() == 1 ? go_from_one(query, is_listed, field, poll)
                    : is_one_front      ? go_from_several(query, field, is_any_below, poll)
                                   : go_from_each(query, *along_edges, field, is_any_below, poll);
  if (!gone) return fail(gone.error());
  if (near != nullptr) {
    take_distances(*near, bound, field, [&](std::uint32_t v) {
      if (is_listed) visited.insert(v);
    });
  }
  // The front accepts vertices a little out of order.
  const double max = reach(limits, field);
  if (is_listed) {
    field.keep_within(max, visited.listed());
    for (const std::uint32_t v : visited.listed()) scratch.vertices[v] = {};
    // Where the detour ended the front, what it left out is left out.
    relax_edges_among(visited, is_search ? Reaching::nothing_more : Reaching::more, adjacency, max,
                      field, poll);
    is_any_below = raise_to_straight_lines(adjacency.mesh(), visited.listed(), field, poll);
  } else {
    if (max < kUnreached) field.forget_beyond(max);
    relax_edges(adjacency, max, field, poll);
    is_any_below = raise_to_straight_lines(adjacency.mesh(), field, poll) || is_any_below;
    const std::size_t used = is_one_front ? scratch.slots.size() : vertex_count;
    run_in_ranges(used, poll, [&](std::size_t, std::size_t begin, std::size_t end, Poll&) {
      const auto vertices = std::span(scratch.vertices).subspan(begin, end - begin);
      std::fill(vertices.begin(), vertices.end(), FrontVertex{});
    });
  }
  if (poll.stopped()) return fail_stopped(cancel);
  scratch.is_clean = true;
  const bool has_ways_along_edges = is_any_below && bound == Bound::upper;
  if (has_ways_along_edges) {
    // One of them was no path's length, whatever made it so: the ways along edges are.
    WavefrontScratch edges;
    auto safe = edge_dijkstra_field(adjacency, sources, asked, edges, cancel);
    if (!safe) return fail(safe.error());
    field.distance = std::move(safe->distance);
    field.nearest_source = std::move(safe->nearest_source);
  }
  if (is_listed && !has_ways_along_edges) {
    field.distance.round_to_floats(bound, visited.listed());
    field.keep_within(asked.max, visited.listed());
    return field;
  }
  field.distance.round_to_floats(bound);
  if (asked.max < kUnreached) field.forget_beyond(asked.max);
  field.count_reached();
  return field;
}

}  // namespace geodesic
