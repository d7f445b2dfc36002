// Novotni and Klein, "Computing Geodesic Distances on Triangular Meshes", WSCG 2002:
// the wavefront that Tang et al. 2007 start from, without the two cases that they
// add. Kept so that the difference can be seen and measured.
#pragma once

#include <span>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "core/wavefront/virtual_source.h"
#include "core/wavefront/wavefront.h"

namespace geodesic {

// The apex's distance: straight from the virtual source, whether or not the line
// crosses the base (their section 4). Past an end of the base the line leaves the
// surface that the distances are known for, and is too short; what comes out below the straight
// line in space is raised to that in the end. Where the circles do not meet there is no virtual
// source, and the ways along the sides remain. `which` and `crossing` say what Tang et al. would
// have done, for the trace back.
[[nodiscard]] inline Arrival arrive_without_cases(double dp, double dq, const UnfoldedApex& w) {
  Arrival arrival = arrive(dp, dq, w);
  const double base2 = w.base2();
  const double sum = dp + dq;
  const double difference = dp - dq;
  const double sy2 = 0.25 * (sum * sum - base2) * (base2 - difference * difference);
  if (arrival.which == Fig4::a || !(sy2 > 0) || !(base2 > 0)) return arrival;
  const double run = w.from_p - 0.5 * (base2 + difference * sum);
  const double rise = std::sqrt(sy2) + w.height;
  arrival.distance = std::sqrt((run * run + rise * rise) / base2);
  return arrival;
}

// As wavefront_field, with that rule. Errors: cancelled.
[[nodiscard]] Result<Field> novotni_field(const Adjacency& adjacency,
                                          std::span<const Source> sources,
                                          const FieldLimits& limits, WavefrontScratch& scratch,
                                          const Cancel& cancel);

}  // namespace geodesic
