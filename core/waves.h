// A wave for each source, each merged into one field: what the wavefront methods
// have in common. They differ in `kArrive`, the rule for a triangle's third vertex.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/adjacency.h"
#include "core/cancel.h"
#include "core/error.h"
#include "core/field.h"
#include "core/remaining_targets.h"
#include "core/vertex_heap.h"
#include "core/virtual_source.h"
#include "core/wavefront.h"
#include "core/wavefront_kernel.h"

namespace geodesic::detail {

// Runs one source's wave into `distance` and `parents`, which it finds unreached;
// without the source's offset, of which the rule's virtual sources know nothing.
// It goes no further from vertices that are clearly nearer to an earlier source
// (`earlier`, empty for none). Tells every vertex it accepted; others stay unreached.
// `waves` is how many there are of them, of which this is the one of that number.
template <Arrival (*kArrive)(double, double, const UnfoldedApex&), class Accepted>
Result<void> run_wave(const Adjacency& adjacency, const Source& source, std::uint32_t number,
                      std::size_t waves, std::span<const double> earlier, double max,
                      RemainingTargets& targets, VertexHeap& heap, std::span<double> distance,
                      std::span<Parents> parents, Poll& poll, Accepted accepted) {
  const auto forget = [&](std::uint32_t v) {
    distance[v] = kUnreached;
    parents[v] = {};
  };
  // A vertex just inside this source's region needs its neighbours outside: go on
  // for a few edges into the other's.
  const double overlap = 3 * adjacency.report().mean_edge;
  const auto worthwhile = [&](std::uint32_t v) {
    return earlier.empty() || distance[v] + source.offset < earlier[v] + overlap;
  };
  max -= source.offset;

  Wavefront<VertexHeap, kArrive> front(adjacency, heap, distance, parents);
  const std::vector<std::uint32_t> first_ring = front.start({source.point, 0}, number);
  for (const std::uint32_t v : first_ring) {
    targets.accept(v);
    if (worthwhile(v)) front.spread_from(v);
  }
  // As if each wave came to every vertex.
  const std::uint64_t total = waves * distance.size();
  std::uint64_t done = number * distance.size();
  bool cancelled = false;
  while (!heap.empty() && !targets.done() && !cancelled) {
    cancelled = poll.cancelled(done++, total);
    if (heap.least().key > max) break;
    const VertexHeap::Entry next = heap.pop();
    targets.accept(next.vertex);
    accepted(next.vertex);
    if (worthwhile(next.vertex)) front.spread_from(next.vertex);
  }
  // What is still considered is not final.
  for (const VertexHeap::Entry& entry : heap.entries()) forget(entry.vertex);
  heap.clear();
  for (const std::uint32_t v : first_ring) {
    if (distance[v] > max) forget(v);
    accepted(v);
  }
  if (cancelled) return fail(ErrorCode::cancelled, "the computation was cancelled");
  return {};
}

// One wave after another, each merged into the field where it is nearer.
template <Arrival (*kArrive)(double, double, const UnfoldedApex&)>
Result<void> run_waves(const Adjacency& adjacency, const FieldLimits& limits, Field& field,
                       WavefrontScratch& scratch, Poll& poll) {
  const std::size_t vertex_count = field.distance.size();
  field.nearest_source.assign(vertex_count, kNone);
  scratch.distance.assign(vertex_count, kUnreached);
  scratch.parents.assign(vertex_count, {});
  double max = limits.max;
  std::vector<std::uint32_t> visited;
  for (std::uint32_t s = 0; s < field.sources.size(); ++s) {
    visited.clear();
    RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
    auto wave =
        run_wave<kArrive>(adjacency, field.sources[s], s, field.sources.size(), field.distance, max,
                          targets, scratch.heap, scratch.distance, scratch.parents, poll,
                          [&](std::uint32_t v) { visited.push_back(v); });
    if (!wave) return wave;
    for (const std::uint32_t v : visited) {
      const double delayed = scratch.distance[v] + field.sources[s].offset;
      if (delayed < field.distance[v]) {
        field.distance[v] = delayed;
        field.parents[v] = scratch.parents[v];
        field.nearest_source[v] = s;
      }
      scratch.distance[v] = kUnreached;
      scratch.parents[v] = {};
      scratch.heap.make_far(v);
    }
    if (!limits.targets.empty()) {
      double farthest = 0;
      for (const std::uint32_t v : limits.targets) farthest = std::max(farthest, field.distance[v]);
      max = std::min(limits.max, farthest);
    }
  }
  // An early wave may have been where a later one, stopped by the targets, was not.
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (field.distance[v] <= max) continue;
    field.distance[v] = kUnreached;
    field.parents[v] = {};
    field.nearest_source[v] = kNone;
  }
  return {};
}

// The whole of wavefront_field, for any rule.
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
  scratch.heap.reset(vertex_count);
  Poll poll(cancel);
  if (sources.size() == 1) {
    RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
    auto wave =
        run_wave<kArrive>(adjacency, sources[0], 0, 1, {}, limits.max, targets, scratch.heap,
                          field.distance, field.parents, poll, [](std::uint32_t) {});
    if (!wave) return fail(wave.error());
    if (sources[0].offset != 0) {
      for (double& d : field.distance) d += sources[0].offset;
    }
  } else if (auto waves = run_waves<kArrive>(adjacency, limits, field, scratch, poll); !waves) {
    return fail(waves.error());
  }

  field.count_reached();
  return field;
}

}  // namespace geodesic::detail
