#include "tests/bench/frontier_costs.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/field/travel_cost.h"
#include "core/steiner/steiner.h"
#include "tests/bench/processor_time.h"

namespace geodesic::bench {
namespace {

Figures by_cost(Asked& asked, TravelCost::Parts parts) {
  constexpr std::uint32_t kFiner = 2 * MethodOptions{}.points_per_edge + 1;
  const auto cost = std::make_shared<const TravelCost>(std::move(parts));
  WavefrontScratch scratch;
  const auto solve = [&](std::uint32_t points_per_edge) {
    FieldLimits limits;
    limits.keep_details = false;
    return take(steiner_field(asked.adjacency(), {&asked.source(), 1}, points_per_edge, limits,
                              scratch, Cancel(), cost));
  };
  Field found;
  Figures figures;
  figures.ms = processor_ms_of([&] { found = solve(MethodOptions{}.points_per_edge); });
  const Field finer = solve(kFiner);
  std::size_t compared = 0;
  for (std::size_t v = 0; v < finer.distance.size(); ++v) {
    const double d = finer.distance[v];
    if (!(d > 0 && d < kUnreached)) continue;
    figures.off += found.distance[v] / d - 1;
    ++compared;
  }
  if (compared > 0) figures.off /= static_cast<double>(compared);
  return figures;
}

}  // namespace

Figures by_weights(Asked& asked) {
  const Mesh& mesh = asked.adjacency().mesh();
  const Vec3 source = position_of(mesh, asked.source().point);
  TravelCost::Parts parts;
  for (const Triangle& face : mesh.faces()) {
    parts.weights.push_back(mesh.positions()[face[0]].x < source.x ? 3 : 1);
  }
  return by_cost(asked, std::move(parts));
}

Figures by_slopes(Asked& asked) {
  TravelCost::Parts parts;
  parts.rate = TravelCost::Rate::table;
  parts.table = {{-1, 2}, {0, 1}, {1, 3}};
  parts.up = {0, 0, 1};
  return by_cost(asked, std::move(parts));
}

}  // namespace geodesic::bench
