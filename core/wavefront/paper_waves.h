// The whole of wavefront_field, for any rule for a triangle's third vertex.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/field/straight_floor.h"
#include "core/field/vertex_set.h"
#include "core/wavefront/kernel.h"
#include "core/wavefront/wavefront.h"
#include "core/wavefront/waves.h"

namespace geodesic::detail {

template <Arrival (*kArrive)(double, double, const UnfoldedApex&)>
Result<Field> waves_field(Method method, const Adjacency& adjacency,
                          std::span<const Source> sources, const FieldLimits& limits,
                          WavefrontScratch& scratch, const Cancel& cancel) {
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field;
  field.method = method;
  field.sources.assign(sources.begin(), sources.end());
  field.distance.assign(vertex_count, kUnreached);
  field.parents.assign(vertex_count, {});
  const auto along_edges = ways_along_edges(adjacency, sources, limits.max, cancel);
  if (!along_edges) return fail(along_edges.error());
  const Cancel rest = after_ways_along_edges(*along_edges, cancel);
  scratch.heap.reset(vertex_count);
  Poll poll(rest);
  // A search for a pair, and a field that ends nearby, cost what they go over, not what the mesh
  // has.
  const bool is_listed =
      sources.size() == 1 && (limits.detour.is_bounded() || limits.max < kUnreached);
  VertexSet visited;
  if (is_listed) visited.reset(vertex_count);
  if (sources.size() == 1) {
    Wavefront<VertexHeap, kArrive> front(adjacency, scratch.heap, field.distance.doubles(),
                                         field.parents);
    RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
    auto wave = run_wave(front, adjacency, sources[0], 0, 1, {}, limits.max, limits.detour, targets,
                         scratch.heap, poll, [&](std::uint32_t v) {
                           if (is_listed) visited.insert(v);
                         });
    if (!wave) return fail(wave.error());
    if (sources[0].offset != 0) {
      for (double& d : field.distance.doubles()) d += sources[0].offset;
    }
  } else {
    scratch.distance.assign(vertex_count, kUnreached);
    scratch.parents.assign(vertex_count, {});
    Wavefront<VertexHeap, kArrive> front(adjacency, scratch.heap, scratch.distance,
                                         scratch.parents);
    auto waves = run_waves(
        front, limits, field, scratch.is_target,
        [&](std::uint32_t s, double max, RemainingTargets& targets, auto accepted) {
          return run_wave(front, adjacency, sources[s], s, sources.size(),
                          {field.distance.doubles(), *along_edges}, max, {}, targets, scratch.heap,
                          poll, accepted);
        },
        [&](std::uint32_t v) {
          front.forget(v);
          scratch.heap.make_far(v);
        });
    if (!waves) return fail(waves.error());
  }

  // On faces without area circles say next to nothing, and past an end of their base any way is
  // too short.
  if (is_listed) {
    raise_to_straight_lines(adjacency.mesh(), visited.listed(), field, poll);
    if (poll.stopped()) return fail_stopped(cancel);
    field.keep_within(limits.max, visited.listed());
    return field;
  }
  raise_to_straight_lines(adjacency.mesh(), field, poll);
  if (poll.stopped()) return fail_stopped(cancel);
  if (limits.max < kUnreached) field.forget_beyond(limits.max);
  field.count_reached();
  return field;
}

}  // namespace geodesic::detail
