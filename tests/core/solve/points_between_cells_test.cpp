// Points inside faces whose nearest source is that of none of the corners.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/core/curves/curve_fixtures.h"

using namespace geodesic;
using fixtures::some_point;
using fixtures::Surface;
using fixtures::test_seed;

TEST_CASE("PointsBetweenCellsAreAsFarAsTheNearestOfSeveralSources") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 60; ++round) {
    CAPTURE(round);
    const auto columns = static_cast<std::uint32_t>(4 + random() % 5);
    const auto rows = static_cast<std::uint32_t>(4 + random() % 5);
    const Surface surface(random() % 2 == 0 ? shapes::plane(columns, rows)
                                            : fixtures::turned_plane(columns, rows, random));
    const Mesh& mesh = surface.mesh();
    std::vector<Source> sources;
    for (std::size_t i = 0; i < 2 + random() % 7; ++i) {
      sources.push_back({some_point(surface, random), 0});
    }
    const Field field = surface.field_by(Method::back_traced, sources);
    const PointArrivals arrivals(surface.adjacency(), field);
    for (int i = 0; i < 40; ++i) {
      const SurfacePoint point = some_point(surface, random);
      const auto found = distance_at_point(surface.adjacency(), field, arrivals, point, Cancel());
      REQUIRE(found);
      double nearest = kUnreached;
      for (const Source& source : sources) {
        nearest =
            std::min(nearest, distance(position_of(mesh, source.point), position_of(mesh, point)));
      }
      CHECK(std::abs(*found - nearest) < 0.01 * std::max(nearest, 0.05));
    }
  }
}
