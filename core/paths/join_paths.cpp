#include "core/paths/join_paths.h"

#include <cstddef>

namespace geodesic {

Path join_paths(std::span<const Path> paths) {
  Path joined;
  if (paths.empty()) return joined;
  joined.source = paths.front().source;
  std::size_t count = 0;
  for (const Path& path : paths) count += path.points.size();
  joined.points.reserve(count);
  for (const Path& path : paths) {
    if (path.points.empty()) continue;
    // A path of one point has no segment that says in which face to go on.
    const bool stays = path.points.size() == 1 && !joined.points.empty();
    if (!stays) {
      if (!joined.points.empty()) joined.points.pop_back();
      joined.points.insert(joined.points.end(), path.points.begin(), path.points.end());
    }
    joined.length += path.length;
  }
  return joined;
}

Path closed_path_along(const Mesh& mesh, std::span<const SurfacePoint> points) {
  Path path;
  if (points.empty()) return path;
  path.points.reserve(points.size() + 1);
  for (const SurfacePoint& point : points) path.points.push_back({point, position_of(mesh, point)});
  path.points.push_back(path.points.front());
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    path.length += distance(path.points[i - 1].position, path.points[i].position);
  }
  return path;
}

}  // namespace geodesic
