#include "server/query/place.h"

#include <algorithm>
#include <cstdint>

namespace geodesic::server {

Result<std::vector<SurfacePoint>> FieldQueries::Place::points(
    const std::vector<proto::PointRequest>& requests,
    std::vector<proto::ResolvedPoint>& echo) const {
  // The catalogue builds and keeps the index; building it waits for a slot of its own.
  std::shared_ptr<const ClosestPointIndex> index;
  const bool searches = std::any_of(requests.begin(), requests.end(), is_searched);
  if (searches) {
    auto built = queries_.catalog_.closest_points(surface_, caller_.part(0, 0));
    if (!built) return fail(std::move(built.error()));
    index = std::move(*built);
  }
  const auto resolve = [&](const Cancel& cancel) -> Result<std::vector<SurfacePoint>> {
    std::vector<SurfacePoint> points;
    points.reserve(requests.size());
    echo.reserve(requests.size());
    constexpr std::uint32_t kPointsBetween = 64;
    Poll poll(cancel, kPointsBetween);
    for (const proto::PointRequest& request : requests) {
      if (poll.cancelled()) return fail_stopped(poll);
      auto placed = resolve_point(*adjacency(), refinement(), index.get(), request, cancel);
      if (!placed) return fail(std::move(placed.error()));
      echo.push_back(std::move(placed->echo));
      points.push_back(placed->point);
    }
    return points;
  };
  const bool may_be_long =
      searches || std::any_of(requests.begin(), requests.end(), [&](const auto& request) {
        return is_on_dropped_face(mesh(), request) || is_on_split_face(refinement(), request);
      });
  // To look the others up takes less time than to wait in a queue.
  if (!may_be_long) {
    auto found = resolve(Cancel(std::cref(caller_)));
    if (!found && found.error().code == ErrorCode::cancelled) return fail(caller_.why_stopped());
    return found;
  }
  return queries_.in_slot(resolve, caller_.part(0, 0));
}

}  // namespace geodesic::server
