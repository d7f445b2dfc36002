#include "core/wavefront/other_sources.h"

#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/wavefront/edge_dijkstra.h"

namespace geodesic::detail {
namespace {

constexpr std::size_t kFew = 2;
constexpr double kWaysAlongEdges = 0.2;

}  // namespace

Result<std::vector<double>> ways_along_edges(const Adjacency& adjacency,
                                             std::span<const Source> sources, double max,
                                             const Cancel& cancel) {
  if (sources.size() <= kFew) return {};
  const std::uint64_t vertex_count = adjacency.mesh().vertex_count();
  if (!cancel.may_take(vertex_count * (sizeof(double) + sizeof(Parents) + sizeof(std::uint32_t)))) {
    return fail_stopped(cancel);
  }
  FieldLimits limits;
  limits.max = max;
  WavefrontScratch scratch;
  auto field =
      edge_dijkstra_field(adjacency, sources, limits, scratch, cancel.part(0, kWaysAlongEdges));
  if (!field) return fail(std::move(field.error()));
  return std::move(field->distance.doubles());
}

Cancel after_ways_along_edges(std::span<const double> along_edges, const Cancel& cancel) {
  return along_edges.empty() ? cancel : cancel.part(kWaysAlongEdges, 1);
}

}  // namespace geodesic::detail
