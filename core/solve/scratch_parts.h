// What a SolveScratch is made of. Not for programs that use the engine: solve_scratch.h is.
#pragma once

#include "core/back_traced/wavefront.h"
#include "core/chen_han/chen_han.h"
#include "core/exact/field.h"
#include "core/solve/solve_scratch.h"
#include "core/wavefront/fast_marching.h"
#include "core/wavefront/wavefront.h"

namespace geodesic {

struct SolveScratch::Parts {
  WavefrontScratch wavefront;
  FastMarchingScratch fast_marching;
  ChenHanScratch chen_han;
  ExactScratch exact;
  BackTracedScratch back_traced;
};

}  // namespace geodesic
