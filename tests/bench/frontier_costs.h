// Rows of cheap ways instead of short ones.
#pragma once

#include "tests/bench/frontier_asked.h"

namespace geodesic::bench {

// Nothing finds the least costs. Off by: the mean above what more than twice as many points on
// edges find.

// One side costs three times as much.
[[nodiscard]] Figures by_weights(Asked& asked);

// Downhill twice, uphill three times as much where it is as steep as 45 degrees; +Z is up.
[[nodiscard]] Figures by_slopes(Asked& asked);

}  // namespace geodesic::bench
