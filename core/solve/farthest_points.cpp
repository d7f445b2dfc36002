#include "core/solve/farthest_points.h"

#include <algorithm>

#include "core/field/longest_edge.h"
#include "core/solve/solve_from_lines.h"

namespace geodesic {
namespace {

// The farthest of the file's vertices that are in a face; kNone when there is no vertex
// at a distance. Of those that walls have doubled, the first.
FarthestPoint farthest_of(const Adjacency& adjacency, std::span<const double> distance) {
  FarthestPoint farthest{kNone, 0};
  const Mesh& mesh = adjacency.mesh();
  for (std::uint32_t v = 0; v < distance.size(); ++v) {
    const double d = distance[v];
    if (d < farthest.radius || d == 0 || adjacency.corners(v).empty()) continue;
    const std::uint32_t source = mesh.source_of_vertex(v);
    if (source >= mesh.source_vertex_count() || mesh.vertex_of_source()[source] != v) continue;
    if (d > farthest.radius || mesh.source_of_vertex(v) < mesh.source_of_vertex(farthest.vertex)) {
      farthest = {v, d};
    }
  }
  return farthest;
}

}  // namespace

Result<FarthestPoints> farthest_points(Method method, const MethodOptions& options,
                                       const Adjacency& adjacency, std::span<const Source> from,
                                       std::size_t count, SolveScratch& scratch,
                                       const Cancel& cancel) {
  return farthest_points(method, options, adjacency, from, nullptr, count, scratch, cancel);
}

Result<FarthestPoints> farthest_points(Method method, const MethodOptions& options,
                                       const Adjacency& adjacency, std::span<const Source> from,
                                       const std::shared_ptr<const SourceLines>& lines,
                                       std::size_t count, SolveScratch& scratch,
                                       const Cancel& cancel) {
  FieldLimits limits;
  limits.keep_details = false;
  // Of each vertex from the nearest of all points so far.
  std::vector<double> distance(adjacency.mesh().vertex_count(), kUnreached);
  // As if every field took as long as the next: they become smaller, but what is
  // done to all vertices for each of them does not.
  const double fields = static_cast<double>(count + (from.empty() ? 0 : 1));
  double done = 0;
  const auto lower_from = [&](std::span<const Source> sources,
                              const std::shared_ptr<const SourceLines>& along) -> Result<void> {
    const Cancel part = cancel.part(done / fields, (done + 1) / fields);
    const auto field =
        along ? solve_from_lines(method, options, adjacency, sources, along, limits, scratch, part)
              : solve_field(method, options, adjacency, sources, limits, scratch, part);
    done += 1;
    if (!field) return fail(field.error());
    if (cancel.requested()) return fail_stopped(cancel);
    for (std::size_t v = 0; v < distance.size(); ++v) {
      distance[v] = std::min(distance[v], field->distance[v]);
    }
    return {};
  };
  if (!from.empty()) {
    if (auto lowered = lower_from(from, lines); !lowered) return fail(lowered.error());
  }
  // A front that comes to a vertex by way of one that is farther, as it does past
  // obtuse angles, must not be cut off there.
  const double slack = longest_edge(adjacency);
  FarthestPoints result;
  FarthestPoint next = farthest_of(adjacency, distance);
  while (next.vertex != kNone && result.points.size() < count) {
    // A field may be too small to ask on its own.
    if (cancel.requested()) return fail_stopped(cancel);
    result.points.push_back(next);
    limits.max = next.radius + slack;
    const Source source{point_at_vertex(adjacency, next.vertex), 0};
    if (auto lowered = lower_from({&source, 1}, nullptr); !lowered) return fail(lowered.error());
    next = farthest_of(adjacency, distance);
  }
  result.covering_radius = next.radius;
  return result;
}

}  // namespace geodesic
