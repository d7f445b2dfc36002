// How far a closed path is from being a closed geodesic, measured in space point by point.
#pragma once

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// In radians, what the lesser of its two sides lacks at a point of a path, less what the rounding
// of positions may make of it; the greatest of all points. 0 where nothing is lacking.
struct LoopStraightness {
  // Of straight ahead: to pi; at a vertex whose angles add up to less than 2 pi, to half of that.
  double turn = 0;
  // Of being locally shortest: to pi, everywhere.
  double lack = 0;
  // Not where the path passes faces without area, or goes on in a face that does not meet the one
  // before: there it has no sides, and nothing says how it turns.
  bool is_known = true;
};

// A loop that lacks no more than this, at any point, is a closed geodesic: vertices may be left
// with tolerance::kStraightAngle, and positions are rounded.
inline constexpr double kMostLack = 1e-6;

// `loop` ends where it begins. Where two segments meet in faces that share no edge there, a path
// has no sides, and nothing lacks. Errors: cancelled.
[[nodiscard]] Result<LoopStraightness> straightness_of_loop(const Adjacency& adjacency,
                                                            const Path& loop, const Cancel& cancel);

// The same for a point inside an edge or a face alone, by the points before and after it on the
// path: `before` is in the face of the segment that comes to `at`, `at` in that of the one that
// leaves.
[[nodiscard]] double turn_inside(const Adjacency& adjacency, const PathPoint& before,
                                 const PathPoint& at, const PathPoint& after);

}  // namespace geodesic
