#include "core/exact_field.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/exact_propagation.h"
#include "core/exact_surface.h"
#include "core/vertex_front.h"

namespace geodesic {

ExactScratch::ExactScratch() : memory(std::make_unique<exact::PropagationMemory>()) {}
ExactScratch::~ExactScratch() = default;
ExactScratch::ExactScratch(ExactScratch&&) noexcept = default;
ExactScratch& ExactScratch::operator=(ExactScratch&&) noexcept = default;

namespace {

Result<Field> field_by_windows(Method method, const Adjacency& adjacency,
                               std::span<const Source> sources, double tolerance, bool keep_windows,
                               const FieldLimits& limits, ExactScratch& scratch,
                               const Cancel& cancel) {
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field = unreached_field(method, sources, vertex_count);
  Poll poll(cancel);
  const bool at_vertices = std::all_of(sources.begin(), sources.end(),
                                       [](const Source& s) { return s.point.at_vertex(); });
  // Vertices have the same distances on faces that are better for it.
  const bool on_mesh = keep_windows || !at_vertices;
  const Triangulation surface =
      on_mesh ? adjacency.triangulation() : exact::surface_for_windows(adjacency, sources, poll);
  exact::Propagation propagation(adjacency, surface, *scratch.memory, field, limits.max, tolerance,
                                 keep_windows, poll);
  if (poll.stopped()) return fail(ErrorCode::cancelled, "the computation was cancelled");
  for (std::uint32_t s = 0; s < sources.size(); ++s) propagation.start(sources[s], s);

  std::vector<std::uint32_t> targets(limits.targets.begin(), limits.targets.end());
  // True once every target's distance is final.
  const auto arrived = [&] {
    if (limits.targets.empty()) return false;
    while (!targets.empty() &&
           propagation.path_length(targets.back()) < propagation.final_below()) {
      targets.pop_back();
    }
    return targets.empty();
  };
  bool stopped = false;
  // A step is some hundred windows over their faces.
  Poll steps(cancel, 16);
  do {
    while (!(stopped = arrived()) && propagation.step()) {
      if (poll.stopped() || steps.cancelled(propagation.reached(), vertex_count)) {
        return fail(ErrorCode::cancelled, "the computation was cancelled");
      }
    }
  } while (!stopped && propagation.mend(poll));

  propagation.raise_to_paths(poll);
  // What was not final when the last target was is farther than any of them.
  double farthest = limits.max;
  if (stopped) {
    farthest = 0;
    for (const std::uint32_t v : limits.targets) farthest = std::max(farthest, field.distance[v]);
  }
  field.forget_beyond(farthest);
  LitWindows lit;
  if (keep_windows) lit = propagation.lit_windows(poll);
  propagation.drop_windows(poll);
  if (keep_windows) {
    field.windows =
        std::make_shared<const WindowTable>(adjacency.faces().size(), std::move(lit), poll);
  }
  if (poll.stopped()) return fail(ErrorCode::cancelled, "the computation was cancelled");
  field.count_reached();
  return field;
}

}  // namespace

Result<Field> exact_field(const Adjacency& adjacency, std::span<const Source> sources,
                          const FieldLimits& limits, ExactScratch& scratch, const Cancel& cancel) {
  return field_by_windows(Method::exact, adjacency, sources, 0, limits.keep_details, limits,
                          scratch, cancel);
}

Result<Field> field_within(double tolerance, const Adjacency& adjacency,
                           std::span<const Source> sources, const FieldLimits& limits,
                           ExactScratch& scratch, const Cancel& cancel) {
  return field_by_windows(Method::back_traced, adjacency, sources, tolerance, false, limits,
                          scratch, cancel);
}

}  // namespace geodesic
