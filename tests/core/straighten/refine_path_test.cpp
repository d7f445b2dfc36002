#include "core/straighten/refine_path.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/solve/pair_search.h"
#include "core/straighten/shorten_path.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

// From three corners of steep hills to everywhere: shortened alone, some of the paths stay
// on the wrong side of a hill.
TEST_CASE("RefinedPathsAreOnTheRightSideOfHills") {
  const Surface surface(shapes::terrain(50, 14, 4));
  const Adjacency& adjacency = surface.adjacency();
  std::size_t pairs = 0;
  std::size_t lowered = 0;
  std::size_t long_ones = 0;
  std::size_t long_before = 0;
  for (const std::uint32_t source : {0U, 49U, 1225U}) {
    const Source from{surface.at(source), 0.5};
    const Field field = surface.field_by(Method::back_traced, {from});
    const Field truth = surface.field_by(Method::exact, {from});
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); v += 3) {
      // At vertices and inside of faces.
      const SurfacePoint to =
          v % 2 == 0 ? point_at_vertex(adjacency, v) : SurfacePoint{v, {0.25, 0.25, 0.5}, kNone};
      const auto traced = *trace_path(adjacency, field, to, Cancel());
      REQUIRE(traced);
      const auto shorter = shorten_path(adjacency, *traced, Cancel());
      const auto refined = refine_path(adjacency, field, to, *traced, Cancel());
      REQUIRE(shorter);
      REQUIRE(refined);
      CHECK(refined->length <= shorter->length);
      ++pairs;
      if (refined->length < shorter->length) {
        ++lowered;
        // Still from the one to the other.
        CHECK(refined->points.front().position == traced->points.front().position);
        CHECK(refined->points.back().position == traced->points.back().position);
        double sum = 0;
        for (std::size_t i = 1; i < refined->points.size(); ++i) {
          sum += distance(refined->points[i - 1].position, refined->points[i].position);
        }
        CHECK(refined->length == doctest::Approx(sum).epsilon(1e-12));
      }
      if (!to.at_vertex()) continue;
      const double exact = truth.distance[v] - 0.5;
      CHECK(refined->length >= exact * (1 - 1e-9));
      if (shorter->length > 1.001 * exact) ++long_before;
      if (refined->length > 1.001 * exact) ++long_ones;
    }
  }
  MESSAGE(pairs << " paths, " << lowered << " lowered; longer by 0.1 %: " << long_before
                << " shortened, " << long_ones << " refined");
  CHECK(lowered > 0);
  CHECK(2 * long_ones <= long_before);
}

// So that nobody can tell an answer with a field at hand from one without.
TEST_CASE("ASearchRefinesItsPathAsOneDoesThroughTheField") {
  const Surface surface(shapes::terrain(60, 14, 4));
  const Adjacency& adjacency = surface.adjacency();
  std::mt19937 random(5);
  const auto any = [&] {
    return point_at_vertex(adjacency,
                           static_cast<std::uint32_t>(random() % surface.mesh().vertex_count()));
  };
  for (const Method method : {Method::back_traced, Method::exact, Method::wavefront}) {
    for (int i = 0; i < 20; ++i) {
      const Source from{any(), 0};
      const SurfacePoint to = any();
      const Field field = surface.field_by(method, {from});
      const auto traced = *trace_path(adjacency, field, to, Cancel());
      REQUIRE(traced);
      const auto expected = refine_path(adjacency, field, to, *traced, Cancel());
      SolveScratch scratch;
      const auto pair =
          pair_search(method, {}, adjacency, from, to, PairPath::refined, scratch, Cancel());
      REQUIRE(expected);
      REQUIRE(pair);
      REQUIRE(pair->path);
      CHECK(std::abs(pair->path->length - expected->length) <= 1e-9 * expected->length);
    }
  }
}

// Through distances by `auto`, a trace alone meanders by a thousandth.
TEST_CASE("PathsByAutoThatAreOnlyTracedAreStraightWithinTheirFaces") {
  std::mt19937 random(fixtures::test_seed());
  for (const TriangleSoup& soup :
       {shapes::icosphere(4), shapes::terrain(60, 4, 2), shapes::torus_knot(120, 10, 0.3)}) {
    const Surface surface(soup);
    const auto any = [&] {
      return surface.at(static_cast<std::uint32_t>(random() % surface.mesh().vertex_count()));
    };
    double excess = 0;
    double before = 0;
    int paths = 0;
    for (int s = 0; s < 4; ++s) {
      const Source from{any(), 0};
      const Field field = surface.field_by(Method::back_traced, {from});
      const Field truth = surface.field_by(Method::exact, {from});
      for (int i = 0; i < 200; ++i, ++paths) {
        const SurfacePoint to = any();
        if (to.vertex == from.point.vertex) continue;
        const auto traced = *trace_path(surface.adjacency(), field, to, Cancel());
        REQUIRE(traced);
        const auto path = *path_through(surface.adjacency(), field, to, PathWork::traced, Cancel());
        REQUIRE(path);
        CHECK(path->length <= traced->length);
        CHECK(path->points.front().position == traced->points.front().position);
        CHECK(path->points.back().position == traced->points.back().position);
        excess += path->length / truth.distance[to.vertex] - 1;
        before += traced->length / truth.distance[to.vertex] - 1;
      }
    }
    MESSAGE("mean excess " << excess / paths << ", only traced " << before / paths);
    CHECK(excess / paths < 1e-3);
    CHECK(2 * excess < before);
  }
}
