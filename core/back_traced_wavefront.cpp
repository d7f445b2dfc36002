#include "core/back_traced_wavefront.h"

#include <algorithm>

#include "core/back_traced_front.h"
#include "core/relax_edges.h"
#include "core/vertex_front.h"
#include "core/waves.h"

namespace geodesic {
namespace {

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

}  // namespace

Result<Field> back_traced_field(const Adjacency& adjacency, std::span<const Source> sources,
                                const FieldLimits& limits, Bound bound, BackTracedScratch& scratch,
                                const Cancel& cancel) {
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field = unreached_field(Method::back_traced, sources, vertex_count);
  scratch.heap.reset(vertex_count);
  scratch.estimate.assign(vertex_count, kUnreached);
  scratch.base.assign(vertex_count, kNone);
  const auto takes =
      bound == Bound::upper ? BackTrace::Takes::paths : BackTrace::Takes::virtual_sources;
  Poll poll(cancel);
  if (sources.size() == 1) {
    BackTracedFront front(adjacency, takes, scratch, field.distance);
    RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
    auto wave = detail::run_wave(front, adjacency, sources[0], 0, 1, {}, limits.max, limits.detour,
                                 targets, scratch.heap, poll, [](std::uint32_t) {});
    if (!wave) return fail(wave.error());
    if (sources[0].offset != 0) {
      for (double& d : field.distance) d += sources[0].offset;
    }
    // The front accepts vertices a little out of order.
    if (const double max = reach(limits, field); max < kUnreached) {
      for (double& d : field.distance) {
        if (d > max) d = kUnreached;
      }
    }
  } else {
    scratch.distance.assign(vertex_count, kUnreached);
    BackTracedFront front(adjacency, takes, scratch, scratch.distance);
    auto waves =
        detail::run_waves(front, adjacency, limits, field, scratch.heap, scratch.is_target, poll);
    if (!waves) return fail(waves.error());
  }
  // Where a detour ended the front, what it left out is left out.
  relax_edges(adjacency, reach(limits, field), !limits.detour.is_bounded(), field, poll);
  if (poll.stopped()) return fail(ErrorCode::cancelled, "the computation was cancelled");
  field.count_reached();
  return field;
}

}  // namespace geodesic
