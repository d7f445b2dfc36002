#include "core/solve_field.h"

#include "core/edge_dijkstra.h"
#include "core/novotni.h"
#include "core/slivers.h"
#include "core/steiner.h"
#include "core/straight_floor.h"

namespace geodesic {
namespace {

// An upper bound where no trace comes to a vertex near the way: paths along such are 1 to 20 %
// too long, while the sides of slivers have few windows. Rounded as the other bounds are.
Result<Field> bound_across_slivers(const Adjacency& adjacency, std::span<const Source> sources,
                                   const FieldLimits& asked, SolveScratch& scratch,
                                   const Cancel& cancel) {
  FieldLimits limits = asked;
  limits.detail_faces = {};  // windows have no bound of their rounding
  auto field = field_within(0, adjacency, sources, limits, scratch.exact, cancel);
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
  if (method == Method::exact || method == Method::chen_han) return true;
  if (method != Method::back_traced) return false;
  if (options.error_at_most) return true;
  // Windows keep no account of their rounding, which an upper bound needs where sides differ by
  // many powers of ten.
  const bool is_even = adjacency.triangulation().is_even && adjacency.delaunay().is_even;
  return options.bound == Bound::upper && is_even && leads_across_slivers(adjacency, sources);
}

namespace {

Result<Field> solve(Method method, const MethodOptions& options, const Adjacency& adjacency,
                    std::span<const Source> sources, const FieldLimits& limits,
                    SolveScratch& scratch, const Cancel& cancel) {
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
        return field_within(*options.error_at_most, adjacency, sources, limits, scratch.exact,
                            cancel);
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
  auto field = solve(method, options, adjacency, sources, limits, scratch, cancel);
  const bool is_bound = options.bound == Bound::upper || options.error_at_most;
  if (field && method == Method::back_traced && is_bound) field->bound = Bound::upper;
  return field;
}

}  // namespace geodesic
