#include "core/exact_field.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/exact_propagation.h"
#include "core/vertex_front.h"

namespace geodesic {

ExactScratch::ExactScratch() : memory(std::make_unique<exact::PropagationMemory>()) {}
ExactScratch::~ExactScratch() = default;
ExactScratch::ExactScratch(ExactScratch&&) noexcept = default;
ExactScratch& ExactScratch::operator=(ExactScratch&&) noexcept = default;

Result<Field> exact_field(const Adjacency& adjacency, std::span<const Source> sources,
                          const FieldLimits& limits, ExactScratch& scratch, const Cancel& cancel) {
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field = unreached_field(Method::exact, sources, vertex_count);
  // A step is a list of windows over an edge, not one vertex.
  Poll poll(cancel, 1024);
  exact::Propagation propagation(adjacency, *scratch.memory, field, limits.max, limits.keep_details,
                                 poll);
  if (poll.stopped()) return fail(ErrorCode::cancelled, "the computation was cancelled");
  for (std::uint32_t s = 0; s < sources.size(); ++s) propagation.start(sources[s], s);

  std::vector<std::uint32_t> targets(limits.targets.begin(), limits.targets.end());
  // True once every target's distance is final.
  const auto arrived = [&] {
    if (limits.targets.empty()) return false;
    while (!targets.empty() && field.distance[targets.back()] < propagation.final_below()) {
      targets.pop_back();
    }
    return targets.empty();
  };
  bool stopped = false;
  do {
    while (!(stopped = arrived()) && propagation.step()) {
      if (poll.cancelled(propagation.reached(), vertex_count)) {
        return fail(ErrorCode::cancelled, "the computation was cancelled");
      }
    }
  } while (!stopped && propagation.mend(poll));

  // What was not final when the last target was is farther than any of them.
  double farthest = limits.max;
  if (stopped) {
    farthest = 0;
    for (const std::uint32_t v : limits.targets) farthest = std::max(farthest, field.distance[v]);
  }
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (field.distance[v] <= farthest) continue;
    field.distance[v] = kUnreached;
    if (!field.nearest_source.empty()) field.nearest_source[v] = kNone;
  }
  if (limits.keep_details) {
    field.windows = std::make_shared<const WindowTable>(adjacency.faces().size(),
                                                        propagation.take_lit_windows(poll), poll);
  }
  if (poll.stopped()) return fail(ErrorCode::cancelled, "the computation was cancelled");
  field.count_reached();
  return field;
}

}  // namespace geodesic
