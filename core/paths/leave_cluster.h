// The way out of a cluster: vertices so close together that rounding hides which of them is
// closer to the sources. An example is the ring at a sphere's pole, which is 1e-16 wide in many
// files.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/paths/arrive_at_point.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// A vertex's cluster is all vertices that edges join it to which are so short that its distance
// loses them in rounding (tolerance::kPoint). The steps lead along such edges to one vertex of the
// cluster and then out: to a source, to a point on an edge, or to a vertex outside that has not
// been `passed`. They take the shortest way out. If a way through a face that has not been
// `entered` is as short, up to rounding, they take that one. There are no steps if no way leads
// out. Looks once at each face round each vertex of the cluster. The result is meaningless if the
// poll says to stop.
[[nodiscard]] std::vector<StepBack> leave_cluster(
    const Adjacency& adjacency, const Field& field, const PointArrivals& arrivals,
    std::uint32_t vertex, const std::function<bool(std::uint32_t face)>& entered,
    const std::function<bool(std::uint32_t vertex)>& passed, Poll& poll);

}  // namespace geodesic
