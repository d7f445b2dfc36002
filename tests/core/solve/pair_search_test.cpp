// The way between two points, searched for where it can be: as from the whole field.
#include "core/solve/pair_search.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "core/paths/edge_path.h"
#include "core/solve/distance_at_point.h"
#include "core/solve/surface_patch.h"
#include "core/straighten/refine_path.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;

namespace {

struct PairMethod {
  Method method;
  std::string name;
  double off;  // the most that a pair may differ from the whole field, of the distance
  Bound bound = Bound::none;
};

const PairMethod kPairMethods[] = {
    {Method::wavefront, "wavefront", 0},
    {Method::novotni, "novotni", 0},
    {Method::dijkstra, "dijkstra", 0},
    {Method::exact, "exact", 1e-12},
    {Method::chen_han, "chen_han", 1e-12},
    {Method::back_traced, "auto", 0},
    {Method::fast_marching, "fast_marching", 0},
    {Method::steiner, "steiner", 0},
    {Method::back_traced, "auto from above", 0, Bound::upper},
};

double size_of_mesh(const Surface& surface) {
  return distance(surface.mesh().box().min, surface.mesh().box().max);
}

// Any vertex in a face, or any point of a face or of one of its sides.
SurfacePoint any_point(const Surface& surface, std::mt19937& random) {
  const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
  const auto part = [&] { return static_cast<double>(1 + random() % 15) / 16; };
  switch (random() % 3) {
    case 0:
      return point_at_vertex(surface.adjacency(), surface.mesh().faces()[f][random() % 3]);
    case 1:
      return point_on_face(surface.adjacency(), f, {0, part(), part()});
    default:
      return point_on_face(surface.adjacency(), f, {part(), part(), part()});
  }
}

Pair pair_of(const Surface& surface, const PairMethod& by, const Source& from,
             const SurfacePoint& to) {
  SolveScratch scratch;
  MethodOptions options;
  options.bound = by.bound;
  auto pair = pair_search(by.method, options, surface.adjacency(), from, to, PairPath::traced,
                          scratch, Cancel());
  REQUIRE(pair);
  return std::move(*pair);
}

void check_as_whole_field(const Surface& surface, const PairMethod& by, const Source& from,
                          const std::vector<SurfacePoint>& to) {
  CAPTURE(by.name);
  MethodOptions options;
  options.bound = by.bound;
  const Field whole = surface.field_by(by.method, {from}, {}, options);
  const PointArrivals arrivals(surface.adjacency(), whole);
  for (const SurfacePoint& point : to) {
    CAPTURE(point.vertex);
    CAPTURE(point.face);
    const Pair pair = pair_of(surface, by, from, point);
    const double expected =
        distance_at_point(surface.adjacency(), whole, arrivals, point, Cancel()).value();
    REQUIRE((pair.distance == kUnreached) == (expected == kUnreached));
    if (expected == kUnreached) {
      CHECK_FALSE(pair.path);
      continue;
    }
    CHECK(std::abs(pair.distance - expected) <= by.off * expected);
    const auto path = *path_through(surface.adjacency(), whole, point, PathWork::traced, Cancel());
    REQUIRE(path.has_value() == pair.path.has_value());
    if (!path) continue;
    fixtures::check_is_a_path(surface.adjacency(), *pair.path, size_of_mesh(surface));
    CHECK(std::abs(pair.path->length - path->length) <= 10 * by.off * size_of_mesh(surface));
    CHECK(pair.path->points.front().position == path->points.front().position);
    CHECK(pair.path->points.back().position == path->points.back().position);
  }
}

}  // namespace

TEST_CASE("APairIsAsFromTheWholeField") {
  for (const auto& [name, soup] :
       {std::pair{"sphere", shapes::icosphere(4)}, std::pair{"terrain", shapes::terrain(60, 4, 2)},
        std::pair{"knot", shapes::torus_knot(120, 10, 0.3)}}) {
    CAPTURE(name);
    const Surface surface(soup);
    std::mt19937 random(7);
    for (const PairMethod& by : kPairMethods) {
      const Source from{any_point(surface, random), 0.25};
      std::vector<SurfacePoint> to;
      for (int i = 0; i < fixtures::all_or(12, 3); ++i) to.push_back(any_point(surface, random));
      check_as_whole_field(surface, by, from, to);
    }
  }
}

TEST_CASE("APairOnALargeMeshHasTheBitsOfTheWholeField") {
  for (const TriangleSoup& soup : {shapes::icosphere(6), shapes::terrain(160, 6, 1)}) {
    const Surface surface(soup);
    std::mt19937 random(11);
    for (const PairMethod& by : kPairMethods) {
      if (by.off > 0 || !searches_pairs(by.method)) continue;
      const Source from{any_point(surface, random), 0};
      std::vector<SurfacePoint> to;
      for (int i = 0; i < fixtures::all_or(8, 2); ++i) to.push_back(any_point(surface, random));
      check_as_whole_field(surface, by, from, to);
    }
  }
}

TEST_CASE("APairOnAnyMeshIsAsFromTheWholeField") {
  const auto check = [](const TriangleSoup& soup, std::uint32_t seed) {
    const Surface surface(soup);
    std::mt19937 random(seed);
    const Source from{any_point(surface, random), 0};
    std::vector<SurfacePoint> to{from.point};
    for (int i = 0; i < 6; ++i) to.push_back(any_point(surface, random));
    for (PairMethod by : kPairMethods) {
      if (by.off > 0) by.off = 1e-9;  // crumbs of 1e-8 beside edges of 100
      check_as_whole_field(surface, by, from, to);
    }
  };
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    check(mesh.soup, 3);
  }
  for (std::uint32_t number = 0; number < fixtures::all_or(60U, 12U); ++number) {
    CAPTURE(number);
    check(RandomMesh(number).soup(), number);
  }
}

TEST_CASE("APairOfOnePoint") {
  const Surface surface(shapes::icosphere(3));
  for (const PairMethod& by : kPairMethods) {
    CAPTURE(by.name);
    for (const SurfacePoint& point : {surface.at(5), surface.on(40, {0.25, 0.5, 0.25})}) {
      const Pair pair = pair_of(surface, by, {point, 0}, point);
      CHECK(pair.distance == doctest::Approx(0).epsilon(1e-12));
      REQUIRE(pair.path);
      CHECK(pair.path->length == doctest::Approx(0).epsilon(1e-12));
    }
  }
}

// A vertex in no face has a way to itself alone, wherever it lies.
TEST_CASE("APairWithAVertexInNoFace") {
  std::mt19937 random(fixtures::test_seed());
  const auto part = [&] { return static_cast<double>(random()) / 4294967296.0; };
  TriangleSoup soup = shapes::plane(9, 9);
  const auto near = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.push_back({8 * part(), 8 * part(), 0.1 + part()});
  const std::uint32_t far_off = near + 1;
  soup.positions.push_back({500, 300 * part(), 0});
  const Surface surface(soup);
  const std::vector<SurfacePoint> others{surface.at(40), surface.on(64, {0, 0.5, 0.5}),
                                         surface.on(64, {0.2, 0.3, 0.5})};
  for (const PairMethod& by : kPairMethods) {
    CAPTURE(by.name);
    MethodOptions options;
    options.bound = by.bound;
    for (const std::uint32_t loose : {near, far_off}) {
      CAPTURE(loose);
      const SurfacePoint here = surface.at(loose);
      SolveScratch scratch;
      for (const PairPath path : {PairPath::none, PairPath::traced, PairPath::refined}) {
        const auto pair = pair_search(by.method, options, surface.adjacency(), {here, 0.25}, here,
                                      path, scratch, Cancel());
        REQUIRE(pair);
        CHECK(pair->distance == doctest::Approx(0.25).epsilon(1e-6));
        REQUIRE(pair->path.has_value() == (path != PairPath::none));
        if (!pair->path) continue;
        CHECK(pair->path->length == 0);
        REQUIRE(pair->path->points.size() == 1);
        CHECK(pair->path->points[0].position == soup.positions[loose]);
      }
      std::vector<SurfacePoint> elsewhere = others;
      elsewhere.push_back(surface.at(loose == near ? far_off : near));
      for (const SurfacePoint& there : elsewhere) {
        const Pair away = pair_of(surface, by, {here, 0}, there);
        CHECK(away.distance == kUnreached);
        CHECK_FALSE(away.path);
        const Pair back = pair_of(surface, by, {there, 0}, here);
        CHECK(back.distance == kUnreached);
        CHECK_FALSE(back.path);
      }
    }
  }
}

TEST_CASE("APatchHasNoPointsOfOtherFaces") {
  TriangleSoup soup = shapes::plane(21, 21);
  const auto loose = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.push_back({0.5, 0.5, 0.1});
  const Surface surface(soup);
  const auto patch =
      SurfacePatch::cut(surface.adjacency(), surface.at(0), surface.at(22), 2, Cancel());
  REQUIRE(patch);
  REQUIRE_FALSE(patch->is_whole());
  const SurfacePoint inner = surface.on(0, {0.2, 0.3, 0.5});
  for (const SurfacePoint& point : {surface.at(0), surface.at(22), inner}) {
    const auto there = patch->inside(point);
    REQUIRE(there);
    CHECK(distance(position_of(patch->adjacency().mesh(), *there),
                   position_of(surface.mesh(), point)) < 1e-12);
  }
  CHECK_FALSE(patch->inside(surface.at(loose)));
  CHECK_FALSE(patch->inside(surface.at(440)));
  const auto last = static_cast<std::uint32_t>(soup.faces.size() - 1);
  CHECK_FALSE(patch->inside(surface.on(last, {0.2, 0.3, 0.5})));
  // No face is near a vertex in no face that is far away.
  soup.positions[loose] = {500, 0, 0};
  const Surface apart(soup);
  const auto none =
      SurfacePatch::cut(apart.adjacency(), apart.at(loose), apart.at(loose), 0, Cancel());
  REQUIRE(none);
  CHECK(none->is_whole());
}

TEST_CASE("APairFarApartLooksAtLittleOfTheSurface") {
  const Surface surface(shapes::icosphere(6));
  const double far_off = std::acos(-1.0) / 2;
  std::uint32_t to = 0;  // a quarter of the way round
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    const auto off = [&](std::uint32_t w) {
      const Vec3 at = surface.mesh().positions()[surface.vertex(0)];
      return std::abs(dot(surface.mesh().positions()[w], at));
    };
    if (off(v) < off(to)) to = v;
  }
  const Vec3 target = surface.mesh().positions()[to];
  for (const Method method :
       {Method::wavefront, Method::novotni, Method::dijkstra, Method::back_traced}) {
    const std::vector<std::uint32_t> targets{to};
    FieldLimits limits;
    limits.targets = targets;
    const Field stopped = surface.field_by(method, {Source{surface.at(0), 0}}, limits);
    limits.detour = {target, 1.1 * far_off};
    const Field field = surface.field_by(method, {Source{surface.at(0), 0}}, limits);
    CHECK(field.distance[to] == doctest::Approx(stopped.distance[to]).epsilon(1e-4));
    CHECK(field.reached < surface.mesh().vertex_count() / 6);
    CHECK(field.reached < stopped.reached / 2);
  }
  const auto patch =
      SurfacePatch::cut(surface.adjacency(), surface.at(0),
                        point_at_vertex(surface.adjacency(), to), 1.001 * far_off, Cancel());
  REQUIRE(patch);
  REQUIRE_FALSE(patch->is_whole());
  CHECK(patch->adjacency().mesh().face_count() < surface.mesh().face_count() / 10);
}

TEST_CASE("APatchThatIsEverythingIsNotCut") {
  const Surface surface(shapes::plane(5, 5));
  const auto patch =
      SurfacePatch::cut(surface.adjacency(), surface.at(0), surface.at(24), 100, Cancel());
  REQUIRE(patch);
  CHECK(patch->is_whole());
}

TEST_CASE("AnEdgePathIsNotMuchLongerThanTheShortest") {
  for (std::uint32_t number = 0; number < 60; ++number) {
    CAPTURE(number);
    const Surface surface(RandomMesh(number).soup());
    std::mt19937 random(number);
    const SurfacePoint from = any_point(surface, random);
    const Field along_edges = surface.field_by(Method::dijkstra, {Source{from, 0}});
    WavefrontScratch scratch;
    for (int i = 0; i < 8; ++i) {
      const SurfacePoint to = any_point(surface, random);
      const auto path = edge_path(surface.adjacency(), from, to, scratch, Cancel());
      REQUIRE(path);
      // To a point in a face the field comes by windows of a plane; at vertices, by edges.
      if (!to.at_vertex()) {
        const Field whole = surface.field_by(Method::exact, {Source{from, 0}});
        const double exact = PointArrivals(surface.adjacency(), whole).distance_at(to);
        REQUIRE(path->has_value() == (exact < kUnreached));
        if (*path) CHECK((*path)->length >= exact * (1 - 1e-9));
      } else {
        const double least = along_edges.distance[to.vertex];
        REQUIRE(path->has_value() == (least < kUnreached));
        if (*path) CHECK((*path)->length >= least * (1 - 1e-9));
        if (*path) CHECK((*path)->length <= kWeightOfTheRest * least * (1 + 1e-9));
      }
      if (*path) {
        fixtures::check_is_a_path(surface.adjacency(), **path, size_of_mesh(surface));
        CHECK((*path)->points.front().position == position_of(surface.mesh(), from));
        CHECK((*path)->points.back().position == position_of(surface.mesh(), to));
      }
    }
  }
}

namespace {

// How often a computation has asked whether to go on, which it does once in so many steps: work
// without a clock.
template <class Compute>
int polls_of(const Compute& compute) {
  int polls = 0;
  const Cancel cancel([&] {
    ++polls;
    return false;
  });
  REQUIRE(compute(cancel));
  return polls;
}

}  // namespace

// Windows go no farther than the target. A search for fronts takes a path along edges, and then
// a margin round it of which windows know nothing: the whole surface.
// However long and thin the mesh's faces are.
TEST_CASE("AlongDelaunayEdgesAWayIsLittleLongerThanTheShortest") {
  std::mt19937 random(fixtures::test_seed());
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    TriangleSoup soup = shapes::terrain(60, 8, random());
    const double factor = 1 + random() % 30;
    for (Vec3& p : soup.positions) p.x *= factor;
    const Surface surface(soup);
    WavefrontScratch scratch;
    const SurfacePoint from = any_point(surface, random);
    const Field exact = surface.field_by(Method::exact, {Source{from, 0}});
    for (int k = 0; k < 20; ++k) {
      const auto v = static_cast<std::uint32_t>(random() % surface.mesh().vertex_count());
      const double d = exact.distance[v];
      if (d < 10 * surface.adjacency().report().mean_edge) continue;
      const SurfacePoint to = point_at_vertex(surface.adjacency(), v);
      const auto length = delaunay_edge_distance(surface.adjacency(), from, to, scratch, Cancel());
      REQUIRE(length);
      REQUIRE(*length);
      CHECK(**length >= d * (1 - 1e-9));
      CHECK(**length <= 1.6 * d);
    }
  }
  // Where there is no way there is no length.
  TriangleSoup apart = shapes::plane(4, 4);
  const auto count = static_cast<std::uint32_t>(apart.positions.size());
  apart.positions.insert(apart.positions.end(), {{50, 0, 0}, {51, 0, 0}, {50, 1, 0}});
  apart.faces.push_back({count, count + 1, count + 2});
  const Surface surface(apart);
  WavefrontScratch scratch;
  const auto none = delaunay_edge_distance(surface.adjacency(), surface.at(0), surface.at(count),
                                           scratch, Cancel());
  REQUIRE(none);
  CHECK(!*none);
}

TEST_CASE("WindowsGoNoFartherThanANearTarget") {
  struct Case {
    std::string name;
    TriangleSoup soup;
    MethodOptions options;
    std::uint32_t row;   // as many vertices as there are in one
    std::uint32_t near;  // vertices on in the same one
  };
  std::vector<Case> cases;
  for (const double tolerance : {0.0, 1e-3, 1e-2}) {
    cases.push_back({"tolerance", shapes::terrain(120, 6, 1), {}, 120, 3});
    cases.back().options.error_at_most = tolerance;
  }
  std::mt19937 random(fixtures::test_seed());
  for (const Case& each : cases) {
    CAPTURE(each.name);
    const Surface surface(each.soup);
    SolveScratch scratch;
    for (int round = 0; round < fixtures::all_or(4, 2); ++round) {
      // Not near the ends, where hardly anything is beyond the target.
      const std::uint32_t rows = surface.mesh().source_vertex_count() / each.row;
      const auto row = static_cast<std::uint32_t>(rows / 3 + random() % (rows / 3));
      const auto v =
          static_cast<std::uint32_t>(each.row * row + each.row / 3 + random() % (each.row / 3));
      const Source from{surface.at(v), 0};
      const SurfacePoint to = surface.at(v + each.near);
      REQUIRE(goes_by_windows(Method::back_traced, each.options, surface.adjacency(), {&from, 1}));
      const int whole = polls_of([&](const Cancel& cancel) {
        return solve_field(Method::back_traced, each.options, surface.adjacency(), {&from, 1}, {},
                           scratch, cancel);
      });
      const int pair = polls_of([&](const Cancel& cancel) {
        return pair_search(Method::back_traced, each.options, surface.adjacency(), from, to,
                           PairPath::none, scratch, cancel);
      });
      if (round == 0) continue;  // a slot's first field on a mesh looks at all of its edges
      CAPTURE(whole);
      CAPTURE(pair);
      CHECK(whole > 20);
      CHECK(5 * pair < whole);
    }
  }
}

// There the distance may be the length of a path, which may lead over what is farther than the
// target: up to 94 % too long, where the field had ended.
TEST_CASE("PairsByAutoInsideFacesAreThoseOfItsFieldWhereItGoesByWindows") {
  const std::uint32_t seed = fixtures::test_seed();
  std::size_t compared = 0;
  SolveScratch scratch;
  for (std::uint32_t number = seed; number < seed + fixtures::all_or(1200, 120); ++number) {
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    const Adjacency& adjacency = surface.adjacency();
    const Source from{surface.at(random.vertex()), 0};
    if (!goes_by_windows(Method::back_traced, {}, adjacency, {&from, 1})) continue;
    const auto field =
        solve_field(Method::back_traced, {}, adjacency, {&from, 1}, {}, scratch, Cancel());
    REQUIRE(field);
    const PointArrivals arrivals(adjacency, *field, nullptr);
    for (int i = 0; i < 5; ++i) {
      const double a = random.unit();
      const double b = (1 - a) * random.unit();
      const SurfacePoint to =
          point_on_face(adjacency, random.below(adjacency.mesh().face_count()), {a, b, 1 - a - b});
      const auto whole = distance_at_point(adjacency, *field, arrivals, to, Cancel());
      const auto pair = pair_search(Method::back_traced, {}, adjacency, from, to, PairPath::none,
                                    scratch, Cancel());
      REQUIRE(whole);
      REQUIRE(pair);
      CHECK(pair->distance == *whole);
      ++compared;
    }
  }
  CHECK(compared > 50);
}

TEST_CASE("ASearchForAPairCanBeCancelled") {
  const Surface surface(shapes::icosphere(6));
  for (const PairMethod& by : kPairMethods) {
    CAPTURE(by.name);
    SolveScratch scratch;
    const auto pair =
        pair_search(by.method, {}, surface.adjacency(), {surface.at(0), 0}, surface.at(3),
                    PairPath::traced, scratch, Cancel([] { return true; }));
    REQUIRE_FALSE(pair);
    CHECK(pair.error().code == ErrorCode::cancelled);
  }
}
