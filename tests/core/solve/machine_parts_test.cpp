// On machine parts of few large and many thin faces `auto` is as `exact`, with and without a bound,
// at vertices, inside faces and along paths.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/paths/arrive_at_point.h"
#include "core/solve/distance_at_point.h"
#include "core/straighten/refine_path.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/solved.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::kFloat;
using fixtures::solved;
using fixtures::Surface;

namespace {

// A star's outline, drawn out of its plane: sides of long thin faces, and caps of triangles from
// corner to corner, few of them large.
TriangleSoup shaft(std::mt19937& random) {
  const std::uint32_t tips = 5 + random() % 30;
  const std::uint32_t between = 1 + random() % 8;
  const double inner = 0.4 + 0.5 * fixtures::fraction(random);
  const double height = 0.1 + 2 * fixtures::fraction(random);
  const std::uint32_t around = 2 * tips * between;
  TriangleSoup soup;
  for (const double z : {0.0, height}) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t corner = i / between;
      const double part = static_cast<double>(i % between) / between;
      const auto at = [&](std::uint32_t k) {
        const double angle = std::numbers::pi * k / tips;
        const double radius = k % 2 == 0 ? 1 : inner;
        return Vec3{radius * std::cos(angle), radius * std::sin(angle), z};
      };
      soup.positions.push_back((1 - part) * at(corner) + part * at(corner + 1));
    }
  }
  for (std::uint32_t i = 0; i < around; ++i) {
    const std::uint32_t next = (i + 1) % around;
    soup.faces.push_back({i, next, around + next});
    soup.faces.push_back({i, around + next, around + i});
  }
  for (const std::uint32_t first : {0U, around}) {
    // The points of a tip to the tip, the polygon of inner corners from one of them.
    const auto corner = [&](std::uint32_t k) { return first + (k % (2 * tips)) * between; };
    for (std::uint32_t k = 1; k < 2 * tips; k += 2) {
      const std::uint32_t end = corner(k + 2);
      for (std::uint32_t i = 0; i < 2 * between; ++i) {
        const std::uint32_t a = first + (k * between + i) % around;
        const std::uint32_t b = first + (k * between + i + 1) % around;
        if (b != end) soup.faces.push_back({a, b, end});
      }
      if (k >= 3 && k + 2 < 2 * tips + 1) soup.faces.push_back({corner(1), corner(k), end});
    }
    if (first > 0) continue;
    // The lower cap looks down.
    for (auto face = soup.faces.begin() + 2 * around; face != soup.faces.end(); ++face) {
      std::swap((*face)[1], (*face)[2]);
    }
  }
  return soup;
}

SurfacePoint point_in_face(const Adjacency& adjacency, std::mt19937& random) {
  const auto face = static_cast<std::uint32_t>(random() % adjacency.mesh().face_count());
  const auto weight = [&] { return 0.001 + fixtures::fraction(random); };
  return point_on_face(adjacency, face, {weight(), weight(), weight()});
}

Field with_details(const Surface& surface, Method method, Bound bound, const Source& source) {
  SolveScratch scratch;
  MethodOptions options;
  options.bound = bound;
  auto field =
      solve_field(method, options, surface.adjacency(), {&source, 1}, {}, scratch, Cancel());
  REQUIRE(field);
  return std::move(*field);
}

}  // namespace

TEST_CASE("OnMachinePartsOfLargeFacesAutoIsExact") {
  std::mt19937 random(fixtures::test_seed());
  for (int i = 0; i < 8; ++i) {
    CAPTURE(i);
    const Surface surface(shaft(random));
    CHECK(surface.adjacency().has_large_faces());
    const auto v = static_cast<std::uint32_t>(random() % surface.mesh().vertex_count());
    const std::vector<Source> sources{{point_at_vertex(surface.adjacency(), v), 0}};
    const Field exact = solved(surface, Method::exact, Bound::none, sources);
    const Field automatic = solved(surface, Method::back_traced, Bound::none, sources);
    const Field upper = solved(surface, Method::back_traced, Bound::upper, sources);
    for (std::uint32_t w = 0; w < surface.mesh().vertex_count(); ++w) {
      CAPTURE(w);
      const double d = exact.distance[w];
      CHECK(std::abs(automatic.distance[w] - d) <= kFloat * d);
      CHECK(upper.distance[w] >= d);
      CHECK(upper.distance[w] <= (1 + 2 * kFloat) * d);
    }
  }
}

TEST_CASE("OnMachinePartsPointsInFacesAndPathsByAutoAreExact") {
  std::mt19937 random(fixtures::test_seed());
  int targets = 0;
  int shortest = 0;
  for (int i = 0; i < 12; ++i) {
    CAPTURE(i);
    const Surface surface(shaft(random));
    const Adjacency& adjacency = surface.adjacency();
    const auto vertex = static_cast<std::uint32_t>(random() % surface.mesh().vertex_count());
    const Source source{
        i % 2 == 0 ? point_at_vertex(adjacency, vertex) : point_in_face(adjacency, random), 0};
    const Field exact = with_details(surface, Method::exact, Bound::none, source);
    const Field automatic = with_details(surface, Method::back_traced, Bound::none, source);
    const Field upper = with_details(surface, Method::back_traced, Bound::upper, source);
    const Field without = solved(surface, Method::back_traced, Bound::none, {source});
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CHECK(automatic.distance[v] == without.distance[v]);
    }
    const PointArrivals exactly(adjacency, exact);
    const PointArrivals automatically(adjacency, automatic);
    const PointArrivals from_above(adjacency, upper);
    for (int k = 0; k < 20; ++k) {
      CAPTURE(k);
      const SurfacePoint target =
          k % 4 == 0
              ? point_at_vertex(
                    adjacency, static_cast<std::uint32_t>(random() % surface.mesh().vertex_count()))
              : point_in_face(adjacency, random);
      const double d = exactly.distance_at(target);
      const auto told = distance_at_point(adjacency, automatic, automatically, target, Cancel());
      const auto bound = distance_at_point(adjacency, upper, from_above, target, Cancel());
      const auto path = path_through(adjacency, automatic, target, PathWork::traced, Cancel());
      REQUIRE((told && bound && path && *path));
      CHECK(std::abs(*told - d) <= kFloat * d);
      CHECK(*bound >= d * (1 - 1e-12));
      CHECK((*path)->length >= (1 - 1e-9) * d);
      fixtures::check_is_a_path(adjacency, **path, 4);
      ++targets;
      if (*bound <= (1 + 2 * kFloat) * d && (*path)->length <= (1 + kFloat) * d) ++shortest;
    }
  }
  // Faces without width hide some ways.
  MESSAGE(shortest << " of " << targets << " paths are the shortest");
  CHECK(10 * shortest >= 9 * targets);
}

// What is asked beside a point, and what a cache has kept, make no difference.
TEST_CASE("OnMachinePartsAPointHasTheDistanceOfTheWholeField") {
  std::mt19937 random(fixtures::test_seed());
  for (int i = 0; i < 12; ++i) {
    CAPTURE(i);
    const Surface surface(shaft(random));
    const Adjacency& adjacency = surface.adjacency();
    const double offset = 0.3 * fixtures::fraction(random);
    const std::vector<Source> sources{{point_in_face(adjacency, random), 0},
                                      {point_in_face(adjacency, random), offset}};
    const auto field = [&](const FieldLimits& limits) {
      SolveScratch scratch;
      auto solved =
          solve_field(Method::back_traced, {}, adjacency, sources, limits, scratch, Cancel());
      REQUIRE(solved);
      return std::move(*solved);
    };
    const Field whole = field({});
    for (int k = 0; k < 10; ++k) {
      CAPTURE(k);
      const SurfacePoint target = point_in_face(adjacency, random);
      const FaceRecord& face = adjacency.face(target.face);
      FieldLimits limits;
      limits.targets = face.vertex;
      limits.beyond_targets = std::sqrt(face.longest2());
      const Field limited = field(limits);
      const PointArrivals of_whole(adjacency, whole);
      const PointArrivals of_limited(adjacency, limited);
      const auto wanted = distance_at_point(adjacency, whole, of_whole, target, Cancel());
      const auto found = distance_at_point(adjacency, limited, of_limited, target, Cancel());
      REQUIRE((wanted && found));
      CHECK(*found == *wanted);
    }
  }
}
