// Fields that end nearby are made at the vertices that their front came to alone.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

TriangleSoup some_surface(std::mt19937& random) {
  switch (random() % 3) {
    case 0:
      return shapes::shuffled(shapes::terrain(30, 2, random()), random());
    case 1:
      return shapes::shuffled(shapes::icosphere(4), random());
    default: {
      TriangleSoup soup = shapes::shuffled(shapes::terrain(25, 2, random()), random());
      for (Vec3& p : soup.positions) p.x *= 1 + static_cast<double>(random() % 20);
      return soup;
    }
  }
}

void check_counts(const Field& field) {
  Field counted = field;
  counted.count_reached();
  CHECK(field.reached == counted.reached);
  CHECK(field.max == counted.max);
  CHECK(field.farthest == counted.farthest);
}

}  // namespace

TEST_CASE("FieldsThatEndNearbyDependOnNothingThatWasAskedBefore") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < fixtures::all_or(60, 15); ++round) {
    CAPTURE(round);
    const Surface surface(some_surface(random));
    const std::uint32_t count = surface.mesh().source_vertex_count();
    const Vec3 sides = surface.mesh().box().max - surface.mesh().box().min;
    SolveScratch scratch;
    for (int query = 0; query < 8; ++query) {
      const Method method = random() % 2 == 0 ? Method::back_traced : Method::wavefront;
      const std::vector<Source> from{{surface.at(static_cast<std::uint32_t>(random() % count)), 0}};
      FieldLimits limits;
      limits.keep_details = false;
      if (random() % 4 != 0) {
        limits.max = norm(sides) * std::pow(10.0, -static_cast<double>(random() % 300) / 100);
      }
      MethodOptions options;
      if (method == Method::back_traced && random() % 2 == 0) options.bound = Bound::upper;
      const auto found =
          solve_field(method, options, surface.adjacency(), from, limits, scratch, Cancel());
      REQUIRE(found.has_value());
      const Field afresh = surface.field_by(method, from, limits, options);
      CHECK(found->distance == afresh.distance);
      check_counts(*found);
      CHECK(found->max <= limits.max);
      // One edge allows no more than its length, wherever both ends are reached.
      for (const Triangle& face : surface.mesh().faces()) {
        for (std::size_t c = 0; c < 3; ++c) {
          const double a = found->distance[face[c]];
          const double b = found->distance[face[(c + 1) % 3]];
          if (method != Method::back_traced || a == kUnreached || b == kUnreached) continue;
          const auto p = surface.mesh().positions();
          CHECK(std::abs(a - b) <=
                distance(p[face[c]], p[face[(c + 1) % 3]]) * (1 + 1e-6) + 1e-6 * a);
        }
      }
    }
  }
}
