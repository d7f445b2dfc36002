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

// Runs one source's wave, as detail::run_wave does for fronts that accept one vertex
// after another.
template <class Accepted>
Result<void> run_wave(BackTracedFront& front, const Adjacency& adjacency,
                      std::span<const Source> sources, std::uint32_t number,
                      const detail::OtherSources& others, double max, const Detour& detour,
                      RemainingTargets& targets, bool is_each_told, Poll& poll, Accepted accepted) {
  const Source& source = sources[number];
  const detail::Worthwhile worthwhile(adjacency, source, others, detour);
  const bool goes_everywhere = others.earlier.empty() && !detour.is_bounded();
  front.start(source.point, worthwhile);
  max -= source.offset;
  const double last = max < kUnreached ? max + front.lag() : max;
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  // As if each wave came to every vertex.
  const std::uint64_t total = sources.size() * vertex_count;
  std::uint64_t done = number * vertex_count;
  bool cancelled = false;
  while ((!targets.done() || front.may_improve()) && !cancelled && front.accept_next(last)) {
    if (poll.stopped()) break;
    const std::size_t count = front.accepted_count();
    cancelled = poll.cancelled_after(count, std::min(done, total), total);
    done += count;
    if (is_each_told) {
      front.for_each_accepted([&](std::uint32_t v) {
        targets.accept(v);
        accepted(v);
      });
    }
    if (!goes_everywhere) {
      front.stop_where([&](std::uint32_t v) { return !worthwhile(v, front.distance(v)); });
    }
    front.spread();
  }
  front.end();
  if (cancelled || poll.stopped()) return fail_stopped(poll);
  return {};
}

}  // namespace

Result<Field> back_traced_field(const Adjacency& adjacency, std::span<const Source> sources,
                                const FieldLimits& asked, Bound bound, const Field* near,
                                BackTracedScratch& scratch, const Cancel& cancel) {
  FieldLimits limits = asked;
  limits.max *= 1 + tolerance::kSinglePrecision;
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field = unreached_field(Method::back_traced, sources, vertex_count);
  if (!scratch.is_clean || scratch.vertices.size() != vertex_count) {
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
  const auto along_edges = detail::ways_along_edges(adjacency, sources, limits.max, cancel);
  if (!along_edges) return fail(along_edges.error());
  const Cancel rest = detail::after_ways_along_edges(*along_edges, cancel);
  Poll poll(rest);
  bool is_any_below = false;
  if (sources.size() == 1) {
    BackTracedFront front(
        adjacency, rule, scratch, field.distance.doubles(),
        is_listed || poll.team() == nullptr ? 1 : poll.team()->parts_for(vertex_count), poll);
    RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
    auto wave = run_wave(front, adjacency, sources, 0, {}, limits.max, limits.detour, targets,
                         is_listed || !limits.targets.empty(), poll, [&](std::uint32_t v) {
                           if (is_listed) visited.insert(v);
                         });
    if (!wave) return fail(wave.error());
    if (sources[0].offset != 0) {
      for (double& d : field.distance.doubles()) d += sources[0].offset;
    }
    if (near != nullptr) {
      take_distances(*near, bound, field, [&](std::uint32_t v) {
        if (is_listed) visited.insert(v);
      });
    }
    // The front accepts vertices a little out of order.
    const double max = reach(limits, field);
    if (is_listed) {
      field.keep_within(max, visited.listed());
    } else if (max < kUnreached) {
      field.forget_beyond(max);
    }
  } else {
    scratch.distance.assign(vertex_count, kUnreached);
    std::vector<std::uint32_t> reached;
    BackTracedFront front(adjacency, rule, scratch, scratch.distance, 1, poll);
    auto waves = detail::run_waves(
        front, limits, field, scratch.is_target,
        [&](std::uint32_t s, double max, RemainingTargets& targets, auto accepted) {
          reached.clear();
          auto wave =
              run_wave(front, adjacency, sources, s, {field.distance.doubles(), *along_edges}, max,
                       {}, targets, true, poll, [&](std::uint32_t v) {
                         reached.push_back(v);
                         accepted(v);
                       });
          is_any_below = raise_to_straight_lines(adjacency.mesh(), sources[s].point, reached,
                                                 scratch.distance, poll) ||
                         is_any_below;
          return wave;
        },
        [&](std::uint32_t v) { front.forget(v); });
    if (!waves) return fail(waves.error());
    if (near != nullptr) {
      take_distances(*near, bound, field, [](std::uint32_t) {});
      if (const double max = reach(limits, field); max < kUnreached) field.forget_beyond(max);
    }
  }
  const double max = reach(limits, field);
  if (is_listed) {
    for (const std::uint32_t v : visited.listed()) scratch.vertices[v] = {};
    // Where the detour ended the front, what it left out is left out.
    relax_edges_among(visited, is_search ? Reaching::nothing_more : Reaching::more, adjacency, max,
                      field, poll);
    is_any_below = raise_to_straight_lines(adjacency.mesh(), visited.listed(), field, poll);
  } else {
    relax_edges(adjacency, max, field, poll);
    is_any_below = raise_to_straight_lines(adjacency.mesh(), field, poll) || is_any_below;
    run_in_ranges(vertex_count, poll, [&](std::size_t, std::size_t begin, std::size_t end, Poll&) {
      const auto vertices = std::span(scratch.vertices).subspan(begin, end - begin);
      std::fill(vertices.begin(), vertices.end(), FrontVertex{});
    });
  }
  if (poll.stopped()) return fail_stopped(cancel);
  scratch.is_clean = true;
  const bool has_ways_along_edges = is_any_below && bound == Bound::upper;
  if (has_ways_along_edges) {
    // One of them was no path's length, whatever made it so: the ways along edges are.
    WavefrontScratch along_edges;
    auto safe = edge_dijkstra_field(adjacency, sources, asked, along_edges, cancel);
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
