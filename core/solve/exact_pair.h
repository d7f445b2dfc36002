// The exact shortest path between two points of a mesh so large that the windows of its whole
// surface would take too much memory: gigabytes from half a million faces on. Windows are kept only
// where they are needed: at the target, and along the path.
#pragma once

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/exact/field.h"
#include "core/field/field.h"
#include "core/solve/pair_search.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// With more vertices than this, exact_pair is better than a field with all windows.
inline constexpr std::uint32_t kManyForWindows = 75'000;

// The distance of `to`, and with `with_path` the shortest path there; nothing where there is
// none.
//
// One field gives the distance and, traced back by distances alone, about where the path is. A
// second one keeps the windows of the faces round that, and the path goes by these. Its length
// is compared with the distance: where the shortest path is elsewhere, as close to where two
// are as long, the faces are more the second time, and all faces the third time.
// Errors: cancelled; too_much_memory, of which the third time takes the most.
[[nodiscard]] Result<Pair> exact_pair(const Adjacency& adjacency, const Source& from,
                                      const SurfacePoint& to, bool with_path, ExactScratch& scratch,
                                      const Cancel& cancel);

}  // namespace geodesic
