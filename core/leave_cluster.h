// The way on from vertices so near to one another that their distances, rounded as they are,
// do not tell which of them is closer to the sources: such as the ring at a sphere's pole,
// which many files have 1e-16 wide.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/adjacency.h"
#include "core/arrive_at_point.h"
#include "core/cancel.h"
#include "core/field.h"

namespace geodesic {

// An edge shorter than this part of a distance is lost in its rounding.
inline constexpr double kLostInRounding = 1e-12;

// The vertex's cluster is what edges as short as that join it to. The steps lead along such
// edges to one of them and then out: to a source, over an edge, or to a vertex elsewhere that
// has not been `passed`; by the shortest way that there is, and of those as short by one through
// a face that has not been `entered`. None when no way leads out. Takes one look at each face of
// the cluster; of no use if the poll says to stop.
[[nodiscard]] std::vector<StepBack> leave_cluster(
    const Adjacency& adjacency, const Field& field, const PointArrivals& arrivals,
    std::uint32_t vertex, const std::function<bool(std::uint32_t face)>& entered,
    const std::function<bool(std::uint32_t vertex)>& passed, Poll& poll);

}  // namespace geodesic
