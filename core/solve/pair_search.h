// The way from one point to one other, without a field of the whole surface.
//
// First some path between the two: along edges (edge_path.h), and for exact methods then
// pulled straight (shorten_path.h). The shortest is no longer than that, and no path is
// shorter than the straight line in space: so whatever is so far from both points that a
// way over it would be longer need not be looked at. That leaves an ellipsoid about the
// two, and of a scan some tenth of the vertices.
#pragma once

#include <cstdint>
#include <optional>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/method.h"
#include "core/paths/trace_path.h"
#include "core/solve/solve_field.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// What is asked for besides the distance: no path, or path_through's.
enum class PairPath : std::uint8_t { none, traced, refined };

struct Pair {
  double distance = kUnreached;  // with the source's offset
  std::optional<Path> path;      // if asked for, and there is one
};

// Whether there is more to a pair by this method than to a field that stops at the
// target.
[[nodiscard]] bool searches_pairs(Method method);

// The distance of `to`, and the path asked for, as from a field of the whole surface. By `dijkstra`
// the distance has the same bits; by `exact` and `chen_han` it differs by rounding, at most 1e-12
// of it. The other methods compute a vertex from its neighbours only approximately, and one beyond
// the ellipsoid may have a say in one within: they get a margin, and where the result comes near
// its edge a wider one, in the end the whole surface. So on scans the bits are those of the whole
// field; on meshes stretched 8 times one pair in fifty differs, by up to 3e-7. For a method that
// searches no pairs this is such a field; without a path, one that stops at the target. Inside a
// face the distance is distance_at_point's, with a path as without one: an upper bound is one.
// Errors: as solve_field.
[[nodiscard]] Result<Pair> pair_search(Method method, const MethodOptions& options,
                                       const Adjacency& adjacency, const Source& from,
                                       const SurfacePoint& to, PairPath path, SolveScratch& scratch,
                                       const Cancel& cancel);

}  // namespace geodesic
