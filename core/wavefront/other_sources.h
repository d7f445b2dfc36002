// What the wave of one source is told of the other sources, so that it goes little farther than
// where its own is the nearest.
#pragma once

#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"

namespace geodesic::detail {

// By vertex, with the sources' offsets. Empty: nothing is known.
struct OtherSources {
  std::span<const double> earlier;      // the distances by the waves before
  std::span<const double> along_edges;  // the lengths of ways along edges from the nearest source
};

// Those lengths, up to `max`; empty for one source or two, whose waves are as quick without. Where
// many sources lie apart, all waves together then go over the surface about twice; without, n of
// them about log n times. Takes a fifth of the progress. Errors: cancelled.
[[nodiscard]] Result<std::vector<double>> ways_along_edges(const Adjacency& adjacency,
                                                           std::span<const Source> sources,
                                                           double max, const Cancel& cancel);

// For the waves that come after.
[[nodiscard]] Cancel after_ways_along_edges(std::span<const double> along_edges,
                                            const Cancel& cancel);

}  // namespace geodesic::detail
