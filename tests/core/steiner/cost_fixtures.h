// Fields and paths of least cost, as tests ask for them.
#pragma once

#include <doctest/doctest.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/steiner/path.h"
#include "core/steiner/steiner.h"
#include "tests/fixtures/surface.h"

namespace geodesic::fixtures {

using Cost = std::shared_ptr<const TravelCost>;

inline constexpr double kClose = 1e-9;

inline Cost cost_of(TravelCost::Parts parts) {
  return std::make_shared<const TravelCost>(std::move(parts));
}

inline Field costs(const Surface& surface, const std::vector<Source>& sources, const Cost& cost,
                   std::uint32_t points = 3, const FieldLimits& limits = {}) {
  WavefrontScratch scratch;
  auto field = steiner_field(surface.adjacency(), sources, points, limits, scratch, Cancel(), cost);
  REQUIRE(field.has_value());
  return std::move(*field);
}

inline std::optional<Path> cheapest(const Surface& surface, const SurfacePoint& from,
                                    const SurfacePoint& to, const Cost& cost,
                                    std::uint32_t points = 3, double tolerance = 1e-6) {
  WavefrontScratch scratch;
  MethodOptions options;
  options.points_per_edge = points;
  options.tolerance = tolerance;
  auto path = steiner_path(surface.adjacency(), {from, 0}, to, options, scratch, Cancel(), cost);
  REQUIRE(path.has_value());
  return std::move(*path);
}

inline double total(const Path& path, const TravelCost& cost) {
  double sum = 0;
  for (const double segment : segment_costs(path, cost)) sum += segment;
  return sum;
}

}  // namespace geodesic::fixtures
