// The path of Tang et al. 2007, section 3.3: from a target back through the
// parents of its distance to the source.
#pragma once

#include <optional>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// Nothing when the target has no distance in this field. The field must reach
// all vertices that are closer than the target: a field of all vertices, or one
// that stopped at the target.
//
// It always comes to an end: it enters a face once and comes to a vertex at most three
// times, whatever the distances are. Where distances do not lead to a source, the path is one
// along edges instead. Errors: cancelled.
[[nodiscard]] Result<std::optional<Path>> trace_path(const Adjacency& adjacency, const Field& field,
                                                     const SurfacePoint& target,
                                                     const Cancel& cancel);

}  // namespace geodesic
