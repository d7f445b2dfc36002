#include "core/solve/solve_field.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/back_traced/slivers.h"
#include "core/base/tolerances.h"
#include "core/field/straight_floor.h"
#include "core/solve/scratch_parts.h"
#include "core/steiner/steiner.h"
#include "core/wavefront/edge_dijkstra.h"
#include "core/wavefront/novotni.h"

namespace geodesic {
namespace {

bool is_even(const Adjacency& adjacency) {
  return adjacency.triangulation().is_even && adjacency.delaunay().is_even;
}

// Distances by windows, made longer by what rounding may have taken; where ways that were traced
// are shorter, which keep an account, those. Both with the same limits.
Result<Field> lesser_of_both(Field by_windows, const Adjacency& adjacency,
                             std::span<const Source> sources, const FieldLimits& limits,
                             SolveScratch::Parts& scratch, const Cancel& cancel) {
  auto traced =
      back_traced_field(adjacency, sources, limits, Bound::upper, scratch.back_traced, cancel);
  if (!traced) return traced;
  const auto& box = adjacency.mesh().box();
  const double extent = norm(box.max - box.min);
  const std::span<double> distance = by_windows.distance.doubles();
  for (std::size_t v = 0; v < distance.size(); ++v) {
    if (distance[v] == kUnreached) continue;
    const double rounding = tolerance::kWindows * (extent + distance[v]);
    const double shortest = distance[v];
    distance[v] += rounding;
    // Below what windows allow, the account was wrong; also where it is below what they say by
    // less.
    if (!(traced->distance[v] <= distance[v] && traced->distance[v] >= shortest - rounding))
      continue;
    distance[v] = std::max(traced->distance[v], shortest);
    if (sources.size() > 1) by_windows.nearest_source[v] = traced->nearest_source[v];
  }
  return by_windows;
}

// Meshes of some thousand faces take some fifty.
constexpr std::uint64_t kMostQuestions = 100;

// An upper bound where no trace comes to a vertex near the way: paths along such are from 1 to
// 20 % too long, or many times, while the sides of slivers have few windows. Rounded as the other
// bounds are.
Result<Field> bound_across_slivers(const Adjacency& adjacency, std::span<const Source> sources,
                                   const FieldLimits& asked, SolveScratch::Parts& scratch,
                                   const Cancel& cancel) {
  FieldLimits limits = asked;
  limits.detail_faces = {};  // windows have no bound of their rounding
  // Of sides of any scale windows may become too many: then traces alone have to do. Counted in
  // questions, so that the answer depends on nothing else.
  const std::uint64_t most = kMostQuestions + adjacency.mesh().face_count() / 2;
  std::uint64_t questions = 0;
  const Cancel bounded([&] { return ++questions > most || cancel.requested(); },
                       [&](double done) { cancel.report(done); }, cancel.memory());
  auto field = field_within(0, adjacency, sources, limits, scratch.exact, bounded);
  if (!field && questions > most && !cancel.requested()) {
    return back_traced_field(adjacency, sources, limits, Bound::upper, scratch.back_traced, cancel);
  }
  if (field && !is_even(adjacency)) {
    field = lesser_of_both(std::move(*field), adjacency, sources, limits, scratch, cancel);
  }
  if (!field) return field;
  Poll poll(cancel);
  const bool is_any_below = raise_to_straight_lines(adjacency.mesh(), *field, poll);
  if (poll.stopped()) return fail_stopped(cancel);
  if (is_any_below) {
    return back_traced_field(adjacency, sources, limits, Bound::upper, scratch.back_traced, cancel);
  }
  field->distance.round_to_floats(Bound::upper);
  if (limits.max < kUnreached) field->forget_beyond(limits.max);
  field->count_reached();
  return field;
}

}  // namespace

bool goes_by_windows(Method method, const MethodOptions& options, const Adjacency& adjacency,
                     std::span<const Source> sources) {
  if (traits_of(method).has_windows) return true;
  if (method != Method::back_traced) return false;
  if (options.error_at_most) return true;
  if (options.bound != Bound::upper) return false;
  // Where sides differ by many powers of ten, few edges can be flipped, and slivers on which
  // straight ways from the source lead along are crossed by those to other vertices.
  return leads_across_slivers(adjacency, sources) ||
         (!is_even(adjacency) && is_of_slivers(adjacency.delaunay()));
}

namespace {

Result<Field> solve(Method method, const MethodOptions& options, const Adjacency& adjacency,
                    std::span<const Source> sources, const FieldLimits& limits,
                    SolveScratch::Parts& scratch, const Cancel& cancel) {
  switch (method) {
    case Method::wavefront:
      return wavefront_field(adjacency, sources, limits, scratch.wavefront, cancel);
    case Method::novotni:
      return novotni_field(adjacency, sources, limits, scratch.wavefront, cancel);
    case Method::dijkstra:
      return edge_dijkstra_field(adjacency, sources, limits, scratch.wavefront, cancel);
    case Method::exact:
      return exact_field(adjacency, sources, limits, scratch.exact, cancel);
    case Method::chen_han:
      return chen_han_field(adjacency, sources, limits, scratch.chen_han, cancel);
    case Method::fast_marching:
      return fast_marching_field(adjacency, sources, limits, scratch.fast_marching, cancel);
    case Method::steiner:
      return steiner_field(adjacency, sources, options.points_per_edge, limits, scratch.wavefront,
                           cancel);
    case Method::back_traced:
      if (options.error_at_most) {
        return not_below_straight_lines(
            adjacency.mesh(),
            field_within(*options.error_at_most, adjacency, sources, limits, scratch.exact, cancel),
            limits, cancel);
      }
      if (goes_by_windows(method, options, adjacency, sources)) {
        return bound_across_slivers(adjacency, sources, limits, scratch, cancel);
      }
      return back_traced_field(adjacency, sources, limits, options.bound, scratch.back_traced,
                               cancel);
  }
  return fail(ErrorCode::internal, "a method without an implementation");
}

}  // namespace

Result<Field> solve_field(Method method, const MethodOptions& options, const Adjacency& adjacency,
                          std::span<const Source> sources, const FieldLimits& limits,
                          SolveScratch& scratch, const Cancel& cancel) {
  auto field = solve(method, options, adjacency, sources, limits, scratch.parts(), cancel);
  const bool is_bound = options.bound == Bound::upper || options.error_at_most;
  if (field && method == Method::back_traced && is_bound) field->bound = Bound::upper;
  return field;
}

}  // namespace geodesic
