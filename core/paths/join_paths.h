// A path through via points, from the paths between them.
#pragma once

#include <span>

#include "core/paths/path.h"
#include "core/surface/point.h"

namespace geodesic {

// The paths one after the other; each must begin where the one before it ends. The
// points where they join stay points of the path, even where it runs straight on,
// and are there once, in the face of the segment that leaves them. The lengths add
// up; the source is that of the first path. No paths make a path without points.
[[nodiscard]] Path join_paths(std::span<const Path> paths);

// The closed path along points, each in the face of the segment that leaves it, and back to the
// first, which is its last point again. No points make a path without points.
[[nodiscard]] Path closed_path_along(const Mesh& mesh, std::span<const SurfacePoint> points);

}  // namespace geodesic
