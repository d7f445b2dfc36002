#include "core/chen_han/chen_han.h"

#include <algorithm>

#include "core/chen_han/front.h"
#include "core/field/remaining_targets.h"
#include "core/field/straight_floor.h"
#include "core/field/vertex_front.h"

namespace geodesic {

Result<Field> chen_han_field(const Adjacency& adjacency, std::span<const Source> sources,
                             const FieldLimits& limits, ChenHanScratch& scratch,
                             const Cancel& cancel) {
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field = unreached_field(Method::chen_han, sources, vertex_count);
  RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
  scratch.accepted.assign(vertex_count, 0);
  Poll poll(cancel);
  chen_han::Front front(adjacency, field, limits, scratch, poll);
  if (poll.stopped()) return fail_stopped(cancel);
  for (std::uint32_t s = 0; s < sources.size() && !poll.stopped(); ++s) front.start(s);

  // Whatever comes out of the queue later is farther: the distances up to its key are
  // final (the "continuous Dijkstra" order).
  double last = limits.max;
  double last_window = limits.max;
  while (!scratch.queue.empty() && scratch.queue.least_key() <= last_window) {
    if (poll.cancelled(front.reached(), vertex_count)) {
      return fail_stopped(cancel);
    }
    const chen_han::Queue::Next next = scratch.queue.pop();
    if (next.vertex == kNone) {
      front.spread(next.window);
      if (front.is_overfull()) {
        return fail(
            ErrorCode::too_large,
            "chen_han: too many windows, as in a heap of faces; `exact` has a way round that");
      }
      continue;
    }
    // A vertex waits once for every time that its distance was lowered.
    if (next.key != scratch.waiting[next.vertex]) continue;
    if (scratch.accepted[next.vertex] == 0) targets.accept(next.vertex);
    scratch.accepted[next.vertex] = 1;
    if (targets.done() && !(last < limits.max)) {
      last = next.key;
      last_window = std::min(limits.max, last + limits.beyond_targets);
      if (!(limits.beyond_targets > 0)) break;
    }
    if (scratch.bends[next.vertex] == 2) front.spread_from(next.vertex);
  }
  field.forget_beyond(last);
  // Where points are as far apart as rounding moves them, windows say less than space does. A
  // target is kept though it is raised above the distance at which the field stopped.
  raise_to_straight_lines(adjacency.mesh(), field, poll);
  if (limits.max < kUnreached) field.forget_beyond(limits.max);
  if (limits.keep_details) field.windows = front.take_windows();
  if (poll.stopped()) return fail_stopped(cancel);
  field.count_reached();
  return field;
}

}  // namespace geodesic
