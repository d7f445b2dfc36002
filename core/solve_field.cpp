#include "core/solve_field.h"

#include "core/edge_dijkstra.h"
#include "core/novotni.h"
#include "core/slivers.h"
#include "core/steiner.h"

namespace geodesic {
namespace {

// An upper bound where no trace comes to a vertex near the way: paths along such are 1 to 20 %
// too long, while the sides of slivers have few windows. Rounded as the other bounds are.
Result<Field> bound_across_slivers(const Adjacency& adjacency, std::span<const Source> sources,
                                   const FieldLimits& limits, ExactScratch& scratch,
                                   const Cancel& cancel) {
  auto field = field_within(0, adjacency, sources, limits, scratch, cancel);
  if (!field) return field;
  field->distance.round_to_floats(Bound::upper);
  if (limits.max < kUnreached) field->forget_beyond(limits.max);
  field->count_reached();
  return field;
}

}  // namespace

Result<Field> solve_field(Method method, const MethodOptions& options, const Adjacency& adjacency,
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
      if (options.bound == Bound::upper && leads_across_slivers(adjacency, sources)) {
        return bound_across_slivers(adjacency, sources, limits, scratch.exact, cancel);
      }
      return back_traced_field(adjacency, sources, limits, options.bound, scratch.back_traced,
                               cancel);
  }
  return fail(ErrorCode::internal, "a method without an implementation");
}

}  // namespace geodesic
