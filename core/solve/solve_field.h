// The distance field of any method.
#pragma once

#include <span>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/method.h"
#include "core/solve/solve_scratch.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Whether these options have windows computed, whatever the method is called: of `exact`, within a
// tolerance, or for an upper bound across slivers. Such a field stops at its targets by itself, and
// takes no detour.
[[nodiscard]] bool goes_by_windows(Method method, const MethodOptions& options,
                                   const Adjacency& adjacency, std::span<const Source> sources);

// Whether a field of these is large enough, and can be divided, so that threads that help
// (base/team.h) are of use.
[[nodiscard]] bool can_be_helped(Method method, const MethodOptions& options,
                                 const Adjacency& adjacency, std::span<const Source> sources);

// The distances from the nearest of the sources by `method`. With no source
// everything is unreached. What each method promises is said in its own header.
// Errors: cancelled; value_out_of_range for options that `steiner` cannot use.
[[nodiscard]] Result<Field> solve_field(Method method, const MethodOptions& options,
                                        const Adjacency& adjacency, std::span<const Source> sources,
                                        const FieldLimits& limits, SolveScratch& scratch,
                                        const Cancel& cancel);

}  // namespace geodesic
