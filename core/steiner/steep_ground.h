// Ground so steep that the graph of `steiner` has too few directions for it: a path that should
// keep its height goes up and down instead, and costs far more than the cheapest.
#pragma once

#include <cstdint>

#include "core/base/cancel.h"
#include "core/field/travel_cost.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// By how much going level may cost more, as a part, for a face to count as too steep.
inline constexpr double kMostAboveLevel = 0.25;

// With k points on each edge, directions are about 1 / (k + 1) apart, so that on a face of slope S
// a path keeps its height only by turns between slopes of S / (2 k + 2) up and down. The greatest S
// for which that costs at most 1 + kMostAboveLevel times what going level does; infinite where no
// slope is too steep. To 2 %.
[[nodiscard]] double steepest_resolved(const TravelCost& cost, std::uint32_t points_per_edge);

// The part of the surface's area, from 0 to 1, whose faces are steeper than `slope`. Of no use if
// the poll says to stop.
[[nodiscard]] double steep_part(const Adjacency& adjacency, Vec3 up, double slope, Poll& poll);

}  // namespace geodesic
