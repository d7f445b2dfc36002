// A wave for each source, each merged into one field: what the wavefront methods
// have in common. They differ in their front.
//
// A Front of `run_wave` has
//   start(source, number)   accepts the vertices next to the source and returns them;
//   expect(v)               v is likely to be the next to be accepted: its faces, which lie
//                           anywhere in memory, can be fetched meanwhile;
//   spread_from(v)          puts vertices into the heap;
//   distance(v), parents(v) what the field gets, once v is accepted;
//   forget(v)               as if the wave had not come there.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/remaining_targets.h"
#include "core/field/vertex_heap.h"
#include "core/surface/adjacency.h"
#include "core/wavefront/other_sources.h"

namespace geodesic::detail {

// Ways along edges bound a wave on all sides and from its start, so its overlap is wider. With one
// overlap 1.4 times as many distances differ from those of whole waves. (That was counted by `auto`
// when it had a wave for each source.)
inline constexpr double kOverlapByEdges = 2;

// Where a wave, whose source starts at zero, goes on from.
struct Worthwhile {
  // Not from vertices that are too much of a detour, nor …
  const Detour& detour;
  std::span<const Vec3> positions;
  // … from those clearly nearer to an earlier source, or to any by the ways along edges; empty for
  // none.
  OtherSources others;
  double offset;   // of this source
  double overlap;  // a vertex just inside this source's region needs its neighbours outside

  Worthwhile(const Adjacency& adjacency, const Source& source, const OtherSources& beside,
             const Detour& around)
      : detour(around),
        positions(adjacency.mesh().positions()),
        others(beside),
        offset(source.offset),
        overlap(3 * adjacency.report().mean_edge) {}

  [[nodiscard]] bool operator()(std::uint32_t v, double distance) const {
    return !detour.is_too_far(distance, positions[v]) && is_nearest(v, distance);
  }
  // As far as is known: whether no other source is clearly nearer.
  [[nodiscard]] bool is_nearest(std::uint32_t v, double distance) const {
    if (others.earlier.empty()) return true;
    const double delayed = distance + offset;
    if (!(delayed < others.earlier[v] + overlap)) return false;
    return others.along_edges.empty() ||
           delayed < others.along_edges[v] + kOverlapByEdges * overlap;
  }
};

// Past obtuse angles a vertex may be nearer than those that it is computed from, by up to the side
// between them, and the next one nearer still. So much may what comes by way of this one be nearer
// than it. Of 2,500 crumpled and grown surfaces with a limit, with 2 sides 2 differ from the whole
// field by `wavefront` and 26 by `novotni`, with 4 one and 11, with 8 none and 4; with none 4
// in 10.
[[nodiscard]] inline double comes_back(const Adjacency& adjacency, std::uint32_t vertex) {
  constexpr double kSides = 8;
  double longest2 = 0;
  for (const std::uint32_t corner : adjacency.corners(vertex)) {
    longest2 = std::max(longest2, adjacency.face(face_of(corner)).longest2());
  }
  return kSides * std::sqrt(longest2);
}

// Runs one source's wave, without the source's offset, of which the rule's virtual
// sources know nothing. It goes no further where that is not worthwhile, for the other
// sources or for the detour. Tells every vertex it accepted; others stay unreached.
// `waves` is how many there are of them, of which this is the one of that number.
template <class Front, class Accepted>
Result<void> run_wave(Front& front, const Adjacency& adjacency, const Source& source,
                      std::uint32_t number, std::size_t waves, const OtherSources& others,
                      double max, const Detour& detour, RemainingTargets& targets, VertexHeap& heap,
                      Poll& poll, Accepted accepted) {
  const Worthwhile worthwhile(adjacency, source, others, detour);
  max -= source.offset;

  const std::vector<std::uint32_t> first_ring = front.start({source.point, 0}, number);
  for (const std::uint32_t v : first_ring) {
    targets.accept(v);
    if (worthwhile(v, front.distance(v))) front.spread_from(v);
  }
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  // As if each wave came to every vertex.
  const std::uint64_t total = waves * vertex_count;
  std::uint64_t done = number * vertex_count;
  bool cancelled = false;
  while (!heap.empty() && !targets.done() && !cancelled) {
    cancelled = poll.cancelled(done++, total);
    const VertexHeap::Entry next = heap.pop();
    if (!heap.empty()) front.expect(heap.least().vertex);
    targets.accept(next.vertex);
    accepted(next.vertex);
    if (next.key > max && next.key - comes_back(adjacency, next.vertex) > max) continue;
    if (worthwhile(next.vertex, next.key)) front.spread_from(next.vertex);
  }
  // What is still considered is not final.
  for (const VertexHeap::Entry& entry : heap.entries()) front.forget(entry.vertex);
  heap.clear();
  for (const std::uint32_t v : first_ring) {
    if (front.distance(v) > max) front.forget(v);
    accepted(v);
  }
  if (cancelled) return fail_stopped(poll);
  return {};
}

// One wave after another, each merged into the field where it is nearer. `run` is given
// the number of a source, the farthest to go, the targets and whom to tell of every
// vertex that was accepted; `forget(v)` is as if no wave had come to v.
template <class Front, class Run, class Forget>
Result<void> run_waves(Front& front, const FieldLimits& limits, Field& field,
                       std::vector<std::uint8_t>& marks, Run run, Forget forget) {
  const std::size_t vertex_count = field.distance.size();
  field.nearest_source.assign(vertex_count, kNone);
  double max = limits.max;
  std::vector<std::uint32_t> visited;
  for (std::uint32_t s = 0; s < field.sources.size(); ++s) {
    visited.clear();
    RemainingTargets targets(limits.targets, vertex_count, marks);
    auto wave = run(s, max, targets, [&](std::uint32_t v) { visited.push_back(v); });
    if (!wave) return wave;
    for (const std::uint32_t v : visited) {
      const double delayed = front.distance(v) + field.sources[s].offset;
      if (delayed < field.distance[v]) {
        field.distance.doubles()[v] = delayed;
        if constexpr (requires { front.parents(v); }) field.parents[v] = front.parents(v);
        field.nearest_source[v] = s;
      }
      forget(v);
    }
    if (!limits.targets.empty()) {
      double farthest = 0;
      for (const std::uint32_t v : limits.targets) farthest = std::max(farthest, field.distance[v]);
      max = std::min(limits.max, farthest);
    }
  }
  // An early wave may have been where a later one, stopped by the targets, was not.
  field.forget_beyond(max);
  return {};
}

}  // namespace geodesic::detail
