// Near the sources, distances by `auto` are exact also where all faces are long and thin, or where
// the surface is rough.
#include "core/solve/near_sources.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/solve/pair_search.h"
#include "core/solve/solve_field.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/solved.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::kFloat;
using fixtures::solved;
using fixtures::Surface;

namespace {

// Each vertex moved by up to half an edge and more.
TriangleSoup crumpled(std::mt19937& random) {
  const std::uint32_t side = 40 + random() % 40;
  TriangleSoup soup = shapes::plane(side, side);
  for (Vec3& p : soup.positions) {
    p = {p.x + 0.4 * fixtures::fraction(random), p.y + 0.4 * fixtures::fraction(random),
         p.z + 0.8 * fixtures::fraction(random)};
  }
  return soup;
}

TriangleSoup stretched(std::mt19937& random) {
  TriangleSoup soup = random() % 2 == 0
                          ? shapes::icosphere(4)
                          : shapes::terrain(30 + random() % 40, 5 + random() % 40, random());
  const double factor = std::exp(fixtures::fraction(random) * 3 + 4);  // 55 to 1,100
  for (Vec3& p : soup.positions) p.x *= factor;
  return soup;
}

std::vector<Source> drawn_sources(std::mt19937& random, const Surface& surface) {
  std::vector<Source> sources;
  for (std::uint32_t count = random() % 3 == 0 ? 3 : 1; count > 0; --count) {
    const double offset = random() % 3 == 0 ? fixtures::fraction(random) : 0;
    if (random() % 2 == 0) {
      const auto v = static_cast<std::uint32_t>(random() % surface.mesh().vertex_count());
      sources.push_back({point_at_vertex(surface.adjacency(), v), offset});
    } else {
      const auto face = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
      sources.push_back({{face, {0.5, 0.3, 0.2}, kNone}, offset});
    }
  }
  return sources;
}

}  // namespace

TEST_CASE("NearTheSourcesOfRoughAndStretchedSurfacesDistancesAreExact") {
  std::mt19937 random(fixtures::test_seed());
  std::size_t looked_at = 0;
  for (int i = 0; i < fixtures::all_or(16, 6); ++i) {
    CAPTURE(i);
    const bool is_rough = i % 4 == 0;
    const Surface surface(is_rough ? crumpled(random) : stretched(random));
    if (is_rough) CHECK(surface.adjacency().is_rough());
    const std::vector<Source> sources = drawn_sources(random, surface);
    ExactScratch scratch;
    const auto near =
        field_near_sources(surface.adjacency(), sources, Bound::none, scratch, Cancel());
    REQUIRE(near);
    if (!*near) continue;  // windows were too many
    const Field exact = solved(surface, Method::exact, Bound::none, sources);
    const Field automatic = solved(surface, Method::back_traced, Bound::none, sources);
    const Field upper = solved(surface, Method::back_traced, Bound::upper, sources);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      if ((*near)->distance[v] == kUnreached) continue;
      CAPTURE(v);
      ++looked_at;
      if (sources.size() > 1) CHECK(automatic.nearest_source[v] != kNone);
      const double d = exact.distance[v];
      CHECK(std::abs(automatic.distance[v] - d) <= kFloat * d);
      CHECK(upper.distance[v] >= d);
      CHECK(upper.distance[v] <= (1 + 2 * kFloat) * d);
    }
  }
  CHECK(looked_at > 0);
}

// The mesh's area says nothing of how many vertices there are about a source.
TEST_CASE("WhereTheColumnsOfAGridGrowUpperBoundsNearTheSourceAreClose") {
  std::mt19937 random(fixtures::test_seed());
  for (int i = 0; i < fixtures::all_or(30, 8); ++i) {
    CAPTURE(i);
    const std::uint32_t side = 30 + random() % 30;
    TriangleSoup soup = shapes::plane(side, side);
    const double growth = 20 + 200 * fixtures::fraction(random);  // last column by first
    for (Vec3& p : soup.positions) p.x = side * std::pow(growth, p.x / side);
    const Surface surface(soup);
    const std::vector<Source> sources = drawn_sources(random, surface);
    const Field exact = solved(surface, Method::exact, Bound::none, sources);
    const Field upper = solved(surface, Method::back_traced, Bound::upper, sources);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      const double d = exact.distance[v];
      CHECK(upper.distance[v] >= (1 - 1e-9) * d);
      CHECK(upper.distance[v] <= 1.01 * d);
    }
  }
}

TEST_CASE("APairNearTheSourceIsAsFarAsTheFieldSays") {
  std::mt19937 random(fixtures::test_seed());
  for (int i = 0; i < fixtures::all_or(6, 2); ++i) {
    CAPTURE(i);
    const Surface surface(stretched(random));
    const auto v = static_cast<std::uint32_t>(random() % surface.mesh().vertex_count());
    const Source source{point_at_vertex(surface.adjacency(), v), 0};
    ExactScratch near_scratch;
    const auto near =
        field_near_sources(surface.adjacency(), {&source, 1}, Bound::none, near_scratch, Cancel());
    REQUIRE(near);
    if (!*near) continue;
    const Field field = solved(surface, Method::back_traced, Bound::none, {source});
    SolveScratch scratch;
    int pairs = 0;
    for (std::uint32_t to = 0; to < surface.mesh().vertex_count() && pairs < 10; ++to) {
      if ((*near)->distance[to] == kUnreached || to == v) continue;
      ++pairs;
      CAPTURE(to);
      const auto pair =
          pair_search(Method::back_traced, {}, surface.adjacency(), source,
                      point_at_vertex(surface.adjacency(), to), PairPath::none, scratch, Cancel());
      REQUIRE(pair);
      CHECK(std::abs(pair->distance - field.distance[to]) <= kFloat * field.distance[to]);
    }
  }
}

// How often windows ask whether to go on decides whether they are too many.
TEST_CASE("HowOftenWindowsAskDoesNotDependOnEarlierQueries") {
  std::mt19937 random(fixtures::test_seed());
  const Surface before(shapes::icosphere(fixtures::all_or(5, 4)));
  for (int i = 0; i < fixtures::all_or(6, 2); ++i) {
    CAPTURE(i);
    const Surface surface(stretched(random));
    const std::vector<Source> sources = drawn_sources(random, surface);
    const auto count_questions = [&](ExactScratch& scratch) {
      REQUIRE(make_ready_for_windows(surface.adjacency(), sources, scratch, Cancel()));
      std::uint64_t questions = 0;
      const Cancel counted([&questions] {
        ++questions;
        return false;
      });
      FieldLimits limits;
      limits.keep_details = false;
      REQUIRE(field_within(0, surface.adjacency(), sources, limits, scratch, counted));
      return questions;
    };
    ExactScratch fresh;
    ExactScratch used;
    const Source source{point_at_vertex(before.adjacency(), 0), 0};
    REQUIRE(exact_field(before.adjacency(), {&source, 1}, {}, used, Cancel()));
    const std::uint64_t expected = count_questions(fresh);
    CHECK(expected > 0);
    CHECK(count_questions(fresh) == expected);
    CHECK(count_questions(used) == expected);
  }
}

TEST_CASE("WhereFacesAreNotThinNothingIsComputedTwice") {
  const Surface surface(shapes::terrain(40, 5, 3));
  const Source source{point_at_vertex(surface.adjacency(), 7), 0};
  ExactScratch scratch;
  const auto near =
      field_near_sources(surface.adjacency(), {&source, 1}, Bound::none, scratch, Cancel());
  REQUIRE(near);
  CHECK(!*near);
}
