// What the methods have in common that settle one vertex after another: a field that
// nothing has reached yet, and the order in which a front goes over it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/method.h"
#include "core/field/remaining_targets.h"
#include "core/field/vertex_heap.h"

namespace geodesic {

[[nodiscard]] inline Field unreached_field(Method method, std::span<const Source> sources,
                                           std::size_t vertex_count) {
  Field field;
  field.method = method;
  field.sources.assign(sources.begin(), sources.end());
  field.distance.assign(vertex_count, kUnreached);
  if (sources.size() > 1) field.nearest_source.assign(vertex_count, kNone);
  return field;
}

// From the closest vertex on, until the limits or the surface end it. A Front has
// `start(source, number)`, `spread_from(vertex)`, which puts vertices into the heap, and
// `forget(vertex)`, for those that have no final distance. `marks` is scratch memory.
// Errors: cancelled.
template <class Front>
[[nodiscard]] Result<void> settle_vertices(Front& front, VertexHeap& heap,
                                           const FieldLimits& limits,
                                           std::vector<std::uint8_t>& marks, Poll& poll,
                                           Field& field) {
  const std::size_t vertex_count = field.distance.size();
  for (std::uint32_t s = 0; s < field.sources.size(); ++s) {
    // Each may be in all faces.
    if (s > 0 && poll.ask()) return fail_stopped(poll);
    front.start(field.sources[s], s);
  }
  RemainingTargets targets(limits.targets, vertex_count, marks);
  std::uint64_t accepted = 0;
  while (!heap.empty() && !targets.done()) {
    if (poll.cancelled(accepted++, vertex_count)) {
      return fail_stopped(poll);
    }
    const VertexHeap::Entry next = heap.pop();
    if (next.key > limits.max) {
      front.forget(next.vertex);
      break;
    }
    targets.accept(next.vertex);
    front.spread_from(next.vertex);
  }
  for (const VertexHeap::Entry& entry : heap.entries()) front.forget(entry.vertex);
  field.count_reached();
  return {};
}

}  // namespace geodesic
