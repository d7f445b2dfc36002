// Farthest-point sampling: vertices spread evenly over a surface, one after the
// other, each as far as can be from those before it. Gonzalez 1985, "Clustering to
// minimize the maximum intercluster distance"; on surfaces Eldar, Lindenbaum,
// Porat, Zeevi 1997, "The farthest point strategy for progressive image sampling".
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/method.h"
#include "core/solve/solve_field.h"
#include "core/surface/adjacency.h"

namespace geodesic {

struct SourceLines;  // core/field/line_waves.h

struct FarthestPoint {
  std::uint32_t vertex = kNone;
  // Its distance from everything before it, mesh units: what was there until then
  // covered the surface within this radius. kUnreached where nothing before it was
  // on the same component.
  double radius = kUnreached;
};

struct FarthestPoints {
  std::vector<FarthestPoint> points;
  // Within this distance of a point, or of `from`, lies every vertex that is in a
  // face. kUnreached when a component has none.
  double covering_radius = 0;
};

// Up to `count` vertices, besides `from`, which are covered already; fewer once
// every vertex in a face is at distance 0. With no `from` the first is the one of
// the lowest source vertex. Of several at the same distance the lowest source
// vertex is taken, and vertices that nothing reaches come before all others.
// Vertices in no face play no part.
//
// Each new point costs a field a little farther than the present covering radius,
// which is what it can improve. Errors: cancelled.
[[nodiscard]] Result<FarthestPoints> farthest_points(Method method, const MethodOptions& options,
                                                     const Adjacency& adjacency,
                                                     std::span<const Source> from,
                                                     std::size_t count, SolveScratch& scratch,
                                                     const Cancel& cancel);
// The same where lines and faces are covered already, too; `from` has their ends
// (solve_from_lines.h). Errors besides: too_much_memory.
[[nodiscard]] Result<FarthestPoints> farthest_points(
    Method method, const MethodOptions& options, const Adjacency& adjacency,
    std::span<const Source> from, const std::shared_ptr<const SourceLines>& lines,
    std::size_t count, SolveScratch& scratch, const Cancel& cancel);

}  // namespace geodesic
