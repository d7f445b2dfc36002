// What holds for every method: on awkward meshes, and properties on random ones.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;

namespace {

// What a method promises of its distances, relative to the true ones.
struct MethodPromise {
  Method method;
  std::string name;
  // Never below the true distance and never above the way along edges. A front that
  // computes a vertex only from faces with two accepted ones may pass an edge by.
  bool in_bounds;
  double awkward;  // the most it is off by on the awkward meshes
  Bound bound = Bound::none;

  [[nodiscard]] bool never_below() const { return in_bounds || bound == Bound::upper; }
  [[nodiscard]] bool never_above() const { return in_bounds || method == Method::back_traced; }
};

constexpr double kRoundingOfAll = 1e-9;
constexpr double kFloatRounding = 1.2e-7;

const MethodPromise kPromises[] = {
    {Method::dijkstra, "dijkstra", true, 0.42},
    {Method::steiner, "steiner", true, 0.10},
    {Method::fast_marching, "fast_marching", false, 0.35},
    {Method::wavefront, "wavefront", false, 0.04},
    {Method::novotni, "novotni", false, 0.2},
    {Method::exact, "exact", true, kRoundingOfAll},
    {Method::chen_han, "chen_han", true, kRoundingOfAll},
    {Method::back_traced, "auto", false, 0.01},
    {Method::back_traced, "auto from above", false, 0.01, Bound::upper},
};

Field field_of(const Surface& surface, Method method, const SurfacePoint& source) {
  return surface.field_by(method, {Source{source, 0}});
}

Field field_of(const Surface& surface, const MethodPromise& promise,
               const std::vector<Source>& sources, const FieldLimits& limits = {}) {
  MethodOptions options;
  options.bound = promise.bound;
  return surface.field_by(promise.method, sources, limits, options);
}

Field field_of(const Surface& surface, const MethodPromise& promise, const SurfacePoint& source) {
  return field_of(surface, promise, {Source{source, 0}});
}

}  // namespace

TEST_CASE("EveryMethodIsRightOnAwkwardMeshes") {
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    const double size = distance(surface.mesh().box().min, surface.mesh().box().max);
    const Field truth = field_of(surface, Method::exact, surface.at(mesh.source));
    for (const MethodPromise& promise : kPromises) {
      CAPTURE(promise.name);
      const Field field = field_of(surface, promise, surface.at(mesh.source));
      double worst = 0;
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        CAPTURE(v);
        REQUIRE((field.distance[v] == kUnreached) == (truth.distance[v] == kUnreached));
        const auto path = surface.path(field, point_at_vertex(surface.adjacency(), v));
        REQUIRE(path.has_value() == (truth.distance[v] != kUnreached));
        if (!path) continue;
        fixtures::check_is_a_path(surface.adjacency(), *path, size);
        CHECK(path->length >= truth.distance[v] * (1 - kRoundingOfAll));
        CHECK(path->points.back().position == surface.mesh().positions()[v]);
        if (truth.distance[v] == 0) {
          CHECK(field.distance[v] == 0);
          continue;
        }
        const double off = field.distance[v] / truth.distance[v] - 1;
        if (promise.never_below()) CHECK(off >= -kRoundingOfAll);
        worst = std::max(worst, std::abs(off));
      }
      CHECK_MESSAGE(worst <= promise.awkward, promise.name, " is off by ", worst);
    }
  }
}

TEST_CASE("EveryMethodStaysBetweenTheStraightLineAndTheWayAlongEdges") {
  for (std::uint32_t number = 0; number < 60; ++number) {
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    const SurfacePoint source = surface.at(random.vertex());
    const Field along_edges = field_of(surface, Method::dijkstra, source);
    for (const MethodPromise& promise : kPromises) {
      CAPTURE(promise.name);
      const Field field = field_of(surface, promise, source);
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        const double d = field.distance[v];
        REQUIRE((d == kUnreached) == (along_edges.distance[v] == kUnreached));
        if (d == kUnreached) continue;
        CHECK((d == 0) == (v == source.vertex));
        const double rounding = field.distance.are_floats() ? kFloatRounding : kRoundingOfAll;
        if (promise.never_above()) CHECK(d <= along_edges.distance[v] * (1 + rounding));
        if (promise.never_below()) {
          const double straight =
              distance(surface.mesh().positions()[v], surface.mesh().positions()[source.vertex]);
          CHECK(d >= straight * (1 - kRoundingOfAll));
        }
      }
    }
  }
}

// Symmetry and the triangle inequality, for those whose distances are the lengths
// of shortest paths in something: the surface, or a graph on it.
// Sources beside one another: the waves of most end at once, in each other's.
TEST_CASE("WhereToStopChangesNoValueOfManySourcesCloseTogether") {
  const Surface surface(shapes::plane(30, 30));
  const auto vertex_count = static_cast<std::uint32_t>(surface.mesh().vertex_count());
  std::vector<Source> sources;
  for (std::uint32_t i = 0; i < 6; ++i) {
    for (std::uint32_t j = 0; j < 6; ++j) {
      sources.push_back({surface.at(30 * (10 + i) + 10 + j), 0.01 * i});
    }
  }
  for (const MethodPromise& promise : kPromises) {
    CAPTURE(promise.name);
    const Field whole = field_of(surface, promise, sources);
    for (const std::uint32_t target : {0U, 30U * 12U + 12U, 30U * 20U + 20U, 899U}) {
      CAPTURE(target);
      const std::vector<std::uint32_t> targets{surface.vertex(target)};
      FieldLimits near;
      near.targets = targets;
      const Field field = field_of(surface, promise, sources, near);
      CHECK(field.distance[targets[0]] ==
            doctest::Approx(whole.distance[targets[0]]).epsilon(1e-12));
      FieldLimits below;
      below.max = whole.distance[targets[0]] / 2;
      const Field part = field_of(surface, promise, sources, below);
      for (std::uint32_t v = 0; v < vertex_count; ++v) {
        if (whole.distance[v] <= below.max) {
          REQUIRE(part.distance[v] == doctest::Approx(whole.distance[v]).epsilon(1e-12));
        } else {
          REQUIRE(part.distance[v] > below.max);
        }
      }
    }
  }
}

TEST_CASE("ShortestPathsOfASpaceMakeAMetric") {
  for (std::uint32_t number = 100; number < 140; ++number) {
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    const SurfacePoint a = surface.at(random.vertex());
    const SurfacePoint b = surface.at(random.vertex());
    for (const MethodPromise& promise : kPromises) {
      if (!promise.in_bounds) continue;
      CAPTURE(promise.name);
      const Field from_a = field_of(surface, promise, a);
      const Field from_b = field_of(surface, promise, b);
      const double ab = from_a.distance[b.vertex];
      REQUIRE((ab == kUnreached) == (from_b.distance[a.vertex] == kUnreached));
      if (ab == kUnreached) continue;
      CHECK(std::abs(ab - from_b.distance[a.vertex]) <= kRoundingOfAll * ab);
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        if (from_a.distance[v] == kUnreached) continue;
        CHECK(from_a.distance[v] <= (ab + from_b.distance[v]) * (1 + kRoundingOfAll));
      }
    }
  }
}

TEST_CASE("TwoExactMethodsAgreeOnRandomMeshes") {
  double worst = 0;
  for (std::uint32_t number = 0; number < 200; ++number) {
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    const bool at_vertex = number % 3 != 0;
    const SurfacePoint source =
        at_vertex ? surface.at(random.vertex())
                  : surface.on(random.below(random.face_count()),
                               {random.unit() + 0.01, number % 2 == 0 ? 0 : random.unit() + 0.01,
                                random.unit() + 0.01});
    const Field one = field_of(surface, Method::exact, source);
    const Field other = field_of(surface, Method::chen_han, source);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      REQUIRE((one.distance[v] == kUnreached) == (other.distance[v] == kUnreached));
      if (one.distance[v] == kUnreached) continue;
      const double apart =
          std::abs(one.distance[v] - other.distance[v]) / std::max(one.distance[v], 1e-300);
      worst = std::max(worst, apart);
      CHECK(apart <= 1e-9);
    }
    // And at points inside faces, from the windows they leave.
    const PointArrivals by_one(surface.adjacency(), one);
    const PointArrivals by_other(surface.adjacency(), other);
    for (int i = 0; i < 20; ++i) {
      const SurfacePoint point =
          surface.on(random.below(random.face_count()),
                     {random.unit() + 0.001, random.unit() + 0.001, random.unit() + 0.001});
      const double d = by_one.distance_at(point);
      REQUIRE((d == kUnreached) == (by_other.distance_at(point) == kUnreached));
      if (d == kUnreached) continue;
      CHECK(std::abs(d - by_other.distance_at(point)) <= 1e-9 * d);
      const auto path = surface.path(one, point);
      REQUIRE(path);
      CHECK(std::abs(path->length - d) <= 1e-9 * d);
    }
  }
  MESSAGE("the two exact methods differ by at most ", worst);
}

// Fronts that come back past obtuse angles go a little beyond the limit, or they would leave out
// what is within it on two surfaces in five.
TEST_CASE("WithALimitAFieldIsThatWithoutItWithinTheLimit") {
  std::mt19937 random(fixtures::test_seed());
  const auto share = [&] { return fixtures::fraction(random); };
  int different = 0;
  for (int round = 0; round < fixtures::all_or(150, 30); ++round) {
    CAPTURE(round);
    const auto side = static_cast<std::uint32_t>(5 + random() % 20);
    TriangleSoup soup = round % 3 == 0   ? fixtures::grown(random, 10 + static_cast<int>(side * 6))
                        : round % 3 == 1 ? fixtures::crumpled(random, side, 3 * share(), 0.03)
                                         : fixtures::dented_ball(random, 1 + side % 4);
    if (round % 4 == 0) {
      for (Vec3& p : soup.positions) p.y *= 30;
    }
    const Surface surface(soup);
    const auto vertex = [&] {
      return point_at_vertex(surface.adjacency(),
                             static_cast<std::uint32_t>(random() % surface.mesh().vertex_count()));
    };
    std::vector<Source> sources{{vertex(), 0}};
    if (round % 5 == 0) sources.push_back({vertex(), 0.1});
    const double part = share();
    for (const Method method : {Method::wavefront, Method::novotni, Method::fast_marching,
                                Method::dijkstra, Method::back_traced}) {
      CAPTURE(static_cast<int>(method));
      const Field whole = surface.field_by(method, sources);
      FieldLimits limits;
      limits.max = part * whole.max;
      const Field within = surface.field_by(method, sources, limits);
      bool is_same = true;
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        const double expected = whole.distance[v] <= limits.max ? whole.distance[v] : kUnreached;
        is_same = is_same && within.distance[v] == expected;
      }
      const bool comes_back = method == Method::wavefront || method == Method::novotni;
      if (comes_back) {
        different += is_same ? 0 : 1;
      } else {
        CHECK(is_same);
      }
    }
  }
  // One in some hundreds, by `novotni`.
  CHECK(different <= 5);
}
