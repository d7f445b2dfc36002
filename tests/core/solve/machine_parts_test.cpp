// On machine parts of few large and many thin faces `auto` is as `exact`, with and without a bound,
// at vertices, inside faces and along paths.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/field/longest_edge.h"
#include "core/paths/arrive_at_point.h"
#include "core/solve/distance_at_point.h"
#include "core/solve/pair_search.h"
#include "core/straighten/refine_path.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/solved.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/turned_part.h"

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

// Of windows kept over the refined surface the oracle is those over the mesh's own faces.
TEST_CASE("OverRefinedPartsPointsAndPathsByExactAndWithinATolerance") {
  const std::uint32_t seed = fixtures::test_seed();
  std::uint32_t refined = 0;
  for (std::uint32_t number = 0; number < fixtures::all_or(48U, 18U); ++number) {
    CAPTURE(number);
    std::mt19937 random(seed + number);
    const auto spoiled = static_cast<fixtures::Spoiled>(number % fixtures::kSpoils);
    const Surface part(fixtures::turned_part(random, spoiled));
    const Adjacency& adjacency = part.adjacency();
    std::vector<Source> sources{{fixtures::drawn_point(adjacency, random), 0}};
    if (random() % 3 == 0) {
      sources.push_back({fixtures::drawn_point(adjacency, random), fixtures::fraction(random)});
    }
    const Field over_mesh = part.field_by(Method::exact, sources);
    FieldLimits limits;
    limits.may_keep_refined = true;
    const Field field = part.field_by(Method::exact, sources, limits);
    const bool has_odd_edges =
        spoiled == fixtures::Spoiled::windings || spoiled == fixtures::Spoiled::fins;
    CHECK((field.kept_windows != nullptr) == (field.windows == nullptr));
    if (has_odd_edges) CHECK(!field.kept_windows);
    if (!field.kept_windows) continue;
    ++refined;
    CHECK(field.kept_windows->is_refined);
    const PointArrivals by_mesh(adjacency, over_mesh);
    const PointArrivals by_refined(adjacency, field);
    for (int k = 0; k < 10; ++k) {
      CAPTURE(k);
      const SurfacePoint target = fixtures::drawn_point(adjacency, random);
      const double d = by_mesh.distance_at(target);
      if (!(d > 0 && d < kUnreached)) continue;
      const auto told = distance_at_point(adjacency, field, by_refined, target, Cancel());
      REQUIRE(told);
      CHECK(std::abs(*told - d) <= 1e-9 * d);
      const auto path = path_through(adjacency, field, target, PathWork::traced, Cancel());
      REQUIRE((path && *path));
      const double along = sources[(*path)->source].offset + (*path)->length;
      CHECK(std::abs(along - d) <= 1e-8 * d);
      fixtures::check_is_a_path(adjacency, **path,
                                norm(part.mesh().box().max - part.mesh().box().min));
      // As far as need be, and no farther.
      const auto around = adjacency.face(target.face);
      const std::vector<std::uint32_t> detail{target.face};
      limits.targets = around.vertex;
      limits.beyond_targets = std::sqrt(around.longest2());
      limits.detail_faces = detail;
      const double tolerance = std::pow(10.0, -1 - 5 * fixtures::fraction(random));
      MethodOptions within;
      within.error_at_most = tolerance;
      const Field near = part.field_by(Method::exact, sources, limits);
      const Field about = part.field_by(Method::back_traced, sources, limits, within);
      for (const Field* limited : {&near, &about}) {
        const PointArrivals arrivals(adjacency, *limited);
        const auto found = distance_at_point(adjacency, *limited, arrivals, target, Cancel());
        REQUIRE(found);
        CHECK(*found >= d * (1 - 1e-9));
        CHECK(*found <= d * (1 + (limited == &near ? 1e-9 : tolerance)));
      }
      limits.targets = {};
      limits.detail_faces = {};
      if (sources.size() > 1) continue;
      SolveScratch scratch;
      const auto pair = pair_search(Method::exact, {}, adjacency, sources.front(), target,
                                    PairPath::refined, scratch, Cancel());
      REQUIRE((pair && pair->path));
      CHECK(std::abs(pair->distance - d) <= 1e-9 * d);
      CHECK(std::abs(pair->path->length - d) <= 1e-8 * d);
    }
  }
  MESSAGE(refined << " parts are refined");
  CHECK(refined > 0);
}
