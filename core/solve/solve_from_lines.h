// The distance field from lines and faces besides points, by any method.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/line_waves.h"
#include "core/paths/path.h"
#include "core/solve/solve_field.h"
#include "core/straighten/refine_path.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Of `auto`, which goes by windows here: waves that are traced back go out from a point each. The
// part by which a distance may be above the shortest.
inline constexpr double kToleranceFromLines = 1e-3;

// What leaves the lines straight is exact by every method (curves/strip_front.h). What bends, at
// the ends of lines and at vertices, is as exact as the method is: by `exact` and `chen_han` all of
// it, but for rounding. `back_traced` without a tolerance takes one of 0.1 %, by windows. But for
// the first two, strips end once there have been 8 a face, and the vertices that they have met go
// on as points. By `wavefront` and `novotni`, which have a wave for each point, only those do that
// have a neighbour to which no strip comes, or by a longer way than along the edge. Along graphs,
// by `dijkstra` and `steiner`, all do.
//
// `sources` are points, among them the ends of all segments; lines->item_of_source says of each
// what it belongs to. The field is whole, up to limits.max, whatever targets there are.
// Errors: as solve_field; too_much_memory; too_large (too many strips, as where two sheets that are
// nearly as long as each other are glued along dozens of lines).
[[nodiscard]] Result<Field> solve_from_lines(Method method, const MethodOptions& options,
                                             const Adjacency& adjacency,
                                             std::span<const Source> sources,
                                             std::shared_ptr<const SourceLines> lines,
                                             const FieldLimits& limits, SolveScratch& scratch,
                                             const Cancel& cancel);

// The path from the nearest place on the lines, or the nearest source, to the target; nothing where
// there is none. It starts at the foot of the perpendicular, or at an end. Refined, it is locally
// shortest from a place of the lines that is nearest to it in its first face. The field has
// details; where it has no lines, this is path_through. Errors: cancelled.
[[nodiscard]] Result<std::optional<Path>> path_from_lines(const Adjacency& adjacency,
                                                          const Field& field,
                                                          const SurfacePoint& target, PathWork work,
                                                          const Cancel& cancel);

}  // namespace geodesic
