#include "core/solve/near_sources.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "core/back_traced/slivers.h"
#include "core/base/tolerances.h"

namespace geodesic {
namespace {

// So many mean edges, but not so far that there are more than so many vertices about each source
// and about all of them, as they are spread on the surface.
constexpr double kEdges = 12;
constexpr double kMostVertices = 1000;
constexpr double kMostVerticesOfAll = 4000;
// Of faces so low, of their longest side: on scans stretched 8 times hardly anything is gained.
constexpr double kOfSlivers = 0.05;
// On larger meshes what is needed of all edges takes as long as a field.
constexpr std::uint32_t kMostVerticesOfMesh = 250'000;
// Some milliseconds. Counted in questions, so that the answer depends on nothing else.
constexpr std::uint64_t kMostQuestionsNear = 500;

}  // namespace

Result<std::optional<Field>> field_near_sources(const Adjacency& adjacency,
                                                std::span<const Source> sources, Bound bound,
                                                ExactScratch& scratch, const Cancel& cancel) {
  const Triangulation surface = adjacency.triangulation();
  // Where many faces meet in an edge, few windows take long.
  if (sources.empty() || surface.is_crowded) return std::nullopt;
  if (!adjacency.is_rough() && !is_of_slivers(surface, kOfSlivers)) return std::nullopt;
  if (adjacency.mesh().vertex_count() > kMostVerticesOfMesh) return std::nullopt;
  const auto ready = make_ready_for_windows(adjacency, sources, scratch, cancel);
  if (!ready) return fail(ready.error());
  std::uint64_t questions = 0;
  bool is_too_much = false;
  const Cancel bounded(
      [&] {
        is_too_much = is_too_much || ++questions > kMostQuestionsNear;
        return is_too_much || cancel.requested();
      },
      {}, cancel.memory());
  // All sources begin at once: the nearest decides.
  double least_offset = kUnreached;
  for (const Source& source : sources) least_offset = std::min(least_offset, source.offset);
  FieldLimits limits;
  const Mesh& mesh = adjacency.mesh();
  const double most_vertices =
      std::min(kMostVertices, kMostVerticesOfAll / static_cast<double>(sources.size()));
  const double most_area = mesh.area() * most_vertices / mesh.vertex_count();
  limits.max = least_offset + std::min(kEdges * adjacency.report().mean_edge,
                                       std::sqrt(most_area / std::numbers::pi));
  limits.keep_details = false;
  auto field = field_within(0, adjacency, sources, limits, scratch, bounded);
  if (!field) {
    if (is_too_much && !cancel.requested()) return std::nullopt;
    return fail(std::move(field.error()));
  }
  const auto& box = mesh.box();
  const double extent = norm(box.max - box.min);
  for (double& d : field->distance.doubles()) {
    const double rounding = tolerance::kWindows * (extent + d);
    if (rounding > tolerance::kSinglePrecision * d) {
      d = kUnreached;  // far smaller than the surface
    } else if (bound == Bound::upper) {
      d += rounding;
    }
  }
  return std::optional(std::move(*field));
}

}  // namespace geodesic
