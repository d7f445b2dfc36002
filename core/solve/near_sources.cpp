#include "core/solve/near_sources.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "core/back_traced/slivers.h"
#include "core/base/tolerances.h"

namespace geodesic {
namespace {

// So many mean edges, but not so far that there are more than so many vertices about each source
// and about all of them.
constexpr double kEdges = 12;
constexpr double kMostVertices = 1000;
constexpr double kMostVerticesOfAll = 4000;
// Of faces so low, of their longest side: on scans stretched 8 times hardly anything is gained.
constexpr double kOfSlivers = 0.05;
// On larger meshes what is needed of all edges takes as long as a field.
constexpr std::uint32_t kMostVerticesOfMesh = 250'000;
// Some milliseconds. Counted in questions, so that the answer depends on nothing else.
constexpr std::uint64_t kMostQuestionsNear = 500;

// With more, the area alone decides: each vertex would be asked how far it is from every source.
constexpr std::size_t kFewSources = 16;

// How far from the sources there are about as many vertices as are wanted: by the mesh's area, as
// if they were spread evenly over it, and by their number within balls about the sources. The
// farther one comes first.
std::array<double, 2> radii_about(const Adjacency& adjacency, std::span<const Source> sources) {
  const Mesh& mesh = adjacency.mesh();
  const double wanted =
      std::min(kMostVertices, kMostVerticesOfAll / static_cast<double>(sources.size()));
  const double most = kEdges * adjacency.report().mean_edge;
  const double area = mesh.area() * wanted / mesh.vertex_count();
  const double by_area = std::min(most, std::sqrt(area / std::numbers::pi));
  if (sources.size() > kFewSources) return {by_area, by_area};
  // Of many vertices some are looked at: they are numbered along a curve that fills space.
  constexpr std::uint32_t kSample = 16'384;
  const std::uint32_t step = mesh.vertex_count() / kSample + 1;
  std::vector<double> away;
  away.reserve(mesh.vertex_count() / step + 1);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); v += step) {
    double least = kUnreached;
    for (const Source& source : sources) {
      least = std::min(least, distance(mesh.positions()[v], position_of(mesh, source.point)));
    }
    away.push_back(least);
  }
  const auto of_all = static_cast<std::size_t>(wanted * double(sources.size()) / step);
  double by_count = most;
  if (of_all < away.size()) {
    const auto last = away.begin() + static_cast<std::ptrdiff_t>(of_all);
    std::nth_element(away.begin(), last, away.end());
    by_count = std::min(most, *last);
  }
  return {std::max(by_area, by_count), std::min(by_area, by_count)};
}

// Nothing if windows become too many.
Result<std::optional<Field>> field_within_radius(double radius, const Adjacency& adjacency,
                                                 std::span<const Source> sources,
                                                 ExactScratch& scratch, const Cancel& cancel) {
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
  limits.max = least_offset + radius;
  limits.keep_details = false;
  auto field = field_within(0, adjacency, sources, limits, scratch, bounded);
  if (field) return std::optional(std::move(*field));
  if (is_too_much && !cancel.requested()) return std::nullopt;
  return fail(std::move(field.error()));
}

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
  std::optional<Field> field;
  double tried = 0;
  for (const double radius : radii_about(adjacency, sources)) {
    if (field || radius == tried) break;
    tried = radius;
    auto found = field_within_radius(radius, adjacency, sources, scratch, cancel);
    if (!found) return found;
    field = std::move(*found);
  }
  if (!field) return std::nullopt;
  const auto& box = adjacency.mesh().box();
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
