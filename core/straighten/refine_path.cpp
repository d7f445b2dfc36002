#include "core/straighten/refine_path.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/paths/arrive_at_point.h"
#include "core/paths/trace_path.h"
#include "core/straighten/shorten_path.h"

namespace geodesic {
namespace {

// A path longer than the field's distance by this part of it: three times the mean error
// of `back_traced` on scans.
constexpr double kDoubtful = 3e-4;
// So many neighbours are asked at most: a mesh may have as many round one vertex as it likes.
constexpr std::size_t kMostAsked = 24;

// The path's last point goes on to the target within that face.
void go_on(const Adjacency& adjacency, std::uint32_t face, std::uint32_t c,
           const SurfacePoint& target, Path& path) {
  SurfacePoint corner{face, {0, 0, 0}, adjacency.face(face).vertex[c]};
  corner.bary[c] = 1;
  PathPoint& last = path.points.back();
  last.point = corner;
  const Vec3 end = position_of(adjacency.mesh(), target);
  path.length += distance(last.position, end);
  path.points.push_back({target, end});
}

}  // namespace

Result<Path> refine_path(const Adjacency& adjacency, const Field& field, const SurfacePoint& target,
                         const Path& traced, const Cancel& cancel) {
  auto best = shorten_path(adjacency, traced, cancel);
  if (!best || field.method != Method::back_traced) return best;
  const auto delayed = [&](const Path& path) {
    return field.sources[path.source].offset + path.length;
  };
  Poll poll(cancel);
  const double expected = PointArrivals(adjacency, field, &poll).distance_at(target);
  if (poll.stopped()) return fail_stopped(poll);
  if (!(delayed(*best) - expected > kDoubtful * best->length)) return best;
  std::vector<std::uint32_t> asked;
  if (target.at_vertex()) asked.push_back(target.vertex);
  for (const SurfacePoint& place : in_all_faces(adjacency, target)) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t neighbour = adjacency.face(place.face).vertex[c];
      if (asked.size() > kMostAsked) return best;
      if (std::find(asked.begin(), asked.end(), neighbour) != asked.end()) continue;
      asked.push_back(neighbour);
      auto other = trace_path(adjacency, field, point_at_vertex(adjacency, neighbour), cancel);
      if (!other) return fail(std::move(other.error()));
      if (!*other) continue;
      go_on(adjacency, place.face, c, place, **other);
      auto shorter = shorten_path(adjacency, **other, cancel);
      if (!shorter) return shorter;
      if (delayed(*shorter) < delayed(*best)) best = std::move(shorter);
    }
  }
  return best;
}

Result<std::optional<Path>> path_through(const Adjacency& adjacency, const Field& field,
                                         const SurfacePoint& target, PathWork work,
                                         const Cancel& cancel) {
  auto traced = trace_path(adjacency, field, target, cancel);
  if (!traced || !*traced) return traced;
  if (work == PathWork::traced && field.method != Method::back_traced) return traced;
  auto path = work == PathWork::refined ? refine_path(adjacency, field, target, **traced, cancel)
                                        : pull_straight(adjacency, **traced, cancel);
  if (!path) return fail(std::move(path.error()));
  return std::move(*path);
}

}  // namespace geodesic
