// A wave for each source, each merged into one field: what the wavefront methods
// have in common. They differ in their front.
//
// A Front has
//   start(source, number)   considers the vertices next to the source, or accepts them
//                           and returns them;
//   expect(v)               v is likely to be the next to be accepted: its faces, which lie
//                           anywhere in memory, can be fetched meanwhile;
//   accept(v)               the vertex v was taken from the heap;
//   spread_from(v)          puts vertices into the heap;
//   settle()                what was accepted and has no final distance gets it;
//   estimate(v)             its distance so far, once accepted; final after settle;
//   distance(v), parents(v) what the field gets;
//   forget(v)               as if the wave had not come there;
//   end()                   after the last of a wave's vertices was accepted;
//   lag()                   by how much a vertex may be accepted after farther ones.
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

namespace geodesic::detail {

// Runs one source's wave, without the source's offset, of which the rule's virtual
// sources know nothing. It goes no further from vertices that are clearly nearer to an
// earlier source (`earlier`, empty for none), nor from those that are too much of a
// detour. Tells every vertex it accepted; others stay unreached. `waves` is how many there are of
// them, of which this is the one of that number.
template <class Front, class Accepted>
Result<void> run_wave(Front& front, const Adjacency& adjacency, const Source& source,
                      std::uint32_t number, std::size_t waves, std::span<const double> earlier,
                      double max, const Detour& detour, RemainingTargets& targets, VertexHeap& heap,
                      Poll& poll, Accepted accepted) {
  // A vertex just inside this source's region needs its neighbours outside: go on
  // for a few edges into the other's.
  const double overlap = 3 * adjacency.report().mean_edge;
  const std::span<const Vec3> positions = adjacency.mesh().positions();
  const auto worthwhile = [&](std::uint32_t v) {
    if (detour.is_too_far(front.estimate(v), positions[v])) return false;
    return earlier.empty() || front.estimate(v) + source.offset < earlier[v] + overlap;
  };
  max -= source.offset;

  const std::vector<std::uint32_t> first_ring = front.start({source.point, 0}, number);
  for (const std::uint32_t v : first_ring) {
    targets.accept(v);
    if (worthwhile(v)) front.spread_from(v);
  }
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  const double last = max < kUnreached ? max + front.lag() : max;
  // As if each wave came to every vertex.
  const std::uint64_t total = waves * vertex_count;
  std::uint64_t done = number * vertex_count;
  bool cancelled = false;
  while (!heap.empty() && !targets.done() && !cancelled) {
    cancelled = poll.cancelled(done++, total);
    if (heap.least().key > last) break;
    const VertexHeap::Entry next = heap.pop();
    if (!heap.empty()) front.expect(heap.least().vertex);
    targets.accept(next.vertex);
    accepted(next.vertex);
    front.accept(next.vertex);
    if (worthwhile(next.vertex)) front.spread_from(next.vertex);
  }
  front.settle();
  front.end();
  // What is still considered is not final.
  for (const VertexHeap::Entry& entry : heap.entries()) front.forget(entry.vertex);
  heap.clear();
  for (const std::uint32_t v : first_ring) {
    if (front.distance(v) > max) front.forget(v);
    accepted(v);
  }
  if (cancelled) return fail(ErrorCode::cancelled, "the computation was cancelled");
  return {};
}

// One wave after another, each merged into the field where it is nearer.
template <class Front>
Result<void> run_waves(Front& front, const Adjacency& adjacency, const FieldLimits& limits,
                       Field& field, VertexHeap& heap, std::vector<std::uint8_t>& marks,
                       Poll& poll) {
  const std::size_t vertex_count = field.distance.size();
  field.nearest_source.assign(vertex_count, kNone);
  double max = limits.max;
  std::vector<std::uint32_t> visited;
  for (std::uint32_t s = 0; s < field.sources.size(); ++s) {
    visited.clear();
    RemainingTargets targets(limits.targets, vertex_count, marks);
    auto wave =
        run_wave(front, adjacency, field.sources[s], s, field.sources.size(), field.distance, max,
                 {}, targets, heap, poll, [&](std::uint32_t v) { visited.push_back(v); });
    if (!wave) return wave;
    for (const std::uint32_t v : visited) {
      const double delayed = front.distance(v) + field.sources[s].offset;
      if (delayed < field.distance[v]) {
        field.distance[v] = delayed;
        if (!field.parents.empty()) field.parents[v] = front.parents(v);
        field.nearest_source[v] = s;
      }
      front.forget(v);
      heap.make_far(v);
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
    if (!field.parents.empty()) field.parents[v] = {};
    field.nearest_source[v] = kNone;
  }
  return {};
}

}  // namespace geodesic::detail
