// One door to all the methods: the distance field of any of them.
#pragma once

#include <span>

#include "core/back_traced/wavefront.h"
#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/chen_han/chen_han.h"
#include "core/exact/field.h"
#include "core/field/field.h"
#include "core/field/method.h"
#include "core/surface/adjacency.h"
#include "core/wavefront/fast_marching.h"
#include "core/wavefront/wavefront.h"

namespace geodesic {

// Memory that queries work in, kept for the next one on the same thread.
struct SolveScratch {
  WavefrontScratch wavefront;
  FastMarchingScratch fast_marching;
  ChenHanScratch chen_han;
  ExactScratch exact;
  BackTracedScratch back_traced;
};

// Whether these options have windows computed, whatever the method is called: of `exact`, within a
// tolerance, or for an upper bound across slivers. Such a field stops at its targets by itself, and
// takes no detour.
[[nodiscard]] bool goes_by_windows(Method method, const MethodOptions& options,
                                   const Adjacency& adjacency, std::span<const Source> sources);

// The distances from the nearest of the sources by `method`. With no source
// everything is unreached. What each method promises is said in its own header.
// Errors: cancelled; value_out_of_range for options that `steiner` cannot use.
[[nodiscard]] Result<Field> solve_field(Method method, const MethodOptions& options,
                                        const Adjacency& adjacency, std::span<const Source> sources,
                                        const FieldLimits& limits, SolveScratch& scratch,
                                        const Cancel& cancel);

}  // namespace geodesic
