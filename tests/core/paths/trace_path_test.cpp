#include "core/paths/trace_path.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "core/field/vertex_front.h"
#include "core/field/window_table.h"
#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/mixed_scales.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::check_is_a_path;
using fixtures::Surface;

TEST_CASE("PathOnAPlaneIsStraight") {
  for (const auto diagonal : {shapes::Diagonal::rising, shapes::Diagonal::falling}) {
    const TriangleSoup soup = shapes::plane(30, 30, diagonal);
    const Surface surface(soup);
    const Field field = surface.field_from(0);
    for (const std::uint32_t target : {1U, 29U, 31U, 500U, 617U, 899U}) {
      const auto path = surface.path(field, surface.at(target));
      REQUIRE(path);
      check_is_a_path(surface.adjacency(), *path, 30);
      CHECK(path->length == doctest::Approx(norm(soup.positions[target])).epsilon(1e-9));
      CHECK(path->points.front().position == soup.positions[0]);
      CHECK(path->points.back().position == soup.positions[target]);
    }
  }
}

TEST_CASE("PathBetweenPointsInsideFaces") {
  const Surface surface(shapes::plane(20, 20));
  const SurfacePoint from = surface.on(10, {0.2, 0.3, 0.5});
  const SurfacePoint to = surface.on(700, {0.6, 0.1, 0.3});
  const auto path = surface.path(surface.field({Source{from, 0}}), to);
  REQUIRE(path);
  check_is_a_path(surface.adjacency(), *path, 20);
  const double straight =
      distance(position_of(surface.mesh(), from), position_of(surface.mesh(), to));
  CHECK(path->length == doctest::Approx(straight).epsilon(1e-9));
  CHECK(path->points.front().position == position_of(surface.mesh(), from));
}

TEST_CASE("PathWithinOneFaceIsOneSegment") {
  const Surface surface(shapes::plane(5, 5));
  const SurfacePoint from = surface.on(7, {0.2, 0.3, 0.5});
  const SurfacePoint to = surface.on(7, {0.5, 0.4, 0.1});
  const auto path = surface.path(surface.field({Source{from, 0}}), to);
  REQUIRE(path);
  CHECK(path->points.size() == 2);
  CHECK(path->length == doctest::Approx(distance(position_of(surface.mesh(), from),
                                                 position_of(surface.mesh(), to))));
}

TEST_CASE("PathToItselfIsOnePoint") {
  const Surface surface(shapes::plane(5, 5));
  const auto at_vertex = surface.path(surface.field_from(7), surface.at(7));
  REQUIRE(at_vertex);
  CHECK(at_vertex->points.size() == 1);
  CHECK(at_vertex->length == 0);
  const SurfacePoint inside = surface.on(3, {0.2, 0.3, 0.5});
  const auto at_point = surface.path(surface.field({Source{inside, 0}}), inside);
  REQUIRE(at_point);
  CHECK(at_point->length == 0);
}

TEST_CASE("PathLeadsToTheNearestOfSeveralSources") {
  const Surface surface(shapes::plane(21, 5));
  const Field field = surface.field({Source{surface.at(0), 0}, Source{surface.at(20), 0}});
  const auto path = surface.path(field, surface.at(15));
  REQUIRE(path);
  CHECK(path->source == 1);
  CHECK(path->length == doctest::Approx(5));
}

TEST_CASE("PathsOnCurvedSurfacesArePaths") {
  for (const TriangleSoup& soup :
       {shapes::icosphere(4), shapes::torus_knot(200, 16, 0.4), shapes::terrain(60, 3, 4),
        shapes::saddle(40, 12), shapes::shuffled(shapes::terrain(60, 3, 4), 2)}) {
    const Surface surface(soup);
    const Field field = surface.field_from(0);
    const PointArrivals arrivals(surface.adjacency(), field);
    double difference = 0;
    std::size_t count = 0;
    for (std::uint32_t f = 0; f < soup.faces.size(); f += 37) {
      const SurfacePoint to = surface.on(f, {0.2, 0.5, 0.3});
      const auto path = surface.path(field, to);
      REQUIRE(path);
      check_is_a_path(surface.adjacency(), *path, 100);
      const double stated = arrivals.distance_at(to);
      difference += std::abs(path->length - stated) / stated;
      ++count;
    }
    CHECK(difference / static_cast<double>(count) < 0.02);
  }
}

TEST_CASE("PathRoundASharpCornerBendsAtIt") {
  // An L: the straight line between its ends leaves the surface.
  const std::vector<shapes::Hole> notch{{10, 10, 20}};
  const Surface surface(shapes::plane_with_holes(31, 31, notch));
  const Field field = surface.field_from(30 * 31);        // top left
  const auto path = surface.path(field, surface.at(30));  // bottom right
  REQUIRE(path);
  check_is_a_path(surface.adjacency(), *path, 31);
  CHECK(path->length == doctest::Approx(2 * std::hypot(20, 10)).epsilon(0.003));
  bool at_corner = false;
  for (const PathPoint& p : path->points) at_corner |= distance(p.position, {10, 10, 0}) < 1e-9;
  CHECK(at_corner);
}

namespace {

// In another face, about as far along the line as a point, where there is such a face.
SurfacePoint point_beside(const Surface& surface, const SurfacePoint& point, std::mt19937& random) {
  const auto positions = surface.mesh().positions();
  const double part = fixtures::any_scale(random, -16, 0);
  const double x = position_of(surface.mesh(), point).x * (1 - part);
  for (int tries = 0; tries < 20; ++tries) {
    const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    const Triangle& t = surface.mesh().faces()[f];
    const double from = positions[t[0]].x;
    const double to = positions[t[1]].x;
    const double third = positions[t[2]].x;
    const double of_third = 0.2 * fixtures::fraction(random);
    const double at = (x - (1 - of_third) * from - of_third * third) / (to - from);
    if (f == point.face || !(at > 0 && at < 1 - of_third)) continue;
    return point_on_face(surface.adjacency(), f, {1 - at - of_third, at, of_third});
  }
  return point;
}

// Exact paths between random points, against their distances.
struct PathsOnLines {
  int count = 0;
  int longer = 0;
  int shorter = 0;

  // To so many points anywhere and to some close to the source.
  void add(const TriangleSoup& soup, std::mt19937& random, int anywhere, int close) {
    if (!Mesh::build(soup)) return;
    const Surface surface(soup);
    const auto point = [&] {
      const double x = fixtures::fraction(random);
      const double y = (1 - x) * fixtures::fraction(random);
      return point_on_face(surface.adjacency(),
                           static_cast<std::uint32_t>(random() % surface.mesh().face_count()),
                           {x, y, 1 - x - y});
    };
    const Source source{point(), 0};
    int questions = 0;
    SolveScratch scratch;
    const auto field = solve_field(Method::exact, {}, surface.adjacency(), {&source, 1}, {},
                                   scratch, Cancel([&] { return ++questions > 300; }));
    if (!field) return;
    const PointArrivals arrivals(surface.adjacency(), *field);
    const double rounding = 1e-13 * norm(surface.mesh().box().max - surface.mesh().box().min);
    for (int i = 0; i < anywhere + close; ++i) {
      const SurfacePoint target =
          i < anywhere ? point() : point_beside(surface, source.point, random);
      const double distance = arrivals.distance_at(target);
      if (distance == kUnreached) continue;
      const auto path = surface.path(*field, target);
      REQUIRE(path);
      ++count;
      shorter += path->length < distance * (1 - 1e-9) - rounding ? 1 : 0;
      longer += path->length > distance * (1 + 1e-9) + rounding ? 1 : 0;
    }
  }
};

}  // namespace

// A field of a plane that says how far its lower right corner is, six from the source, and leads a
// path there by a vertex that is aside.
TEST_CASE("AnOffsetHidesNoDetourOfAPath") {
  constexpr std::uint32_t kSide = 7;
  constexpr std::uint32_t kTarget = kSide - 1;
  constexpr std::uint32_t kAside = 3 * kSide - 1;
  const Surface plane(shapes::plane(kSide, kSide));
  struct Delayed {
    Method method;
    double offset;  // so great that a detour of three is little beside it
  };
  for (const Delayed& each :
       {Delayed{Method::fast_marching, 1e3}, Delayed{Method::back_traced, 1e3},
        Delayed{Method::exact, 1e10}, Delayed{Method::chen_han, 1e10}}) {
    CAPTURE(static_cast<int>(each.method));
    for (const double offset : {0.0, each.offset}) {
      CAPTURE(offset);
      const Source source{plane.at(0), offset};
      Field field = unreached_field(each.method, {&source, 1}, plane.mesh().vertex_count());
      std::vector<double>& known = field.distance.doubles();
      known[plane.vertex(0)] = offset;
      known[plane.vertex(kTarget)] = offset + 6;
      known[plane.vertex(kAside)] = offset + 5;
      if (traits_of(each.method).has_windows) {
        const Cancel never;
        Poll poll(never);
        field.windows = std::make_shared<const WindowTable>(plane.adjacency().faces().size(),
                                                            VisibleIntervals(), poll);
      }
      const auto path = plane.path(field, plane.at(kTarget));
      REQUIRE(path);
      check_is_a_path(plane.adjacency(), *path, kSide);
      CHECK(path->length == doctest::Approx(6));
    }
  }
}

// Over faces that are lines a shortest path may come to one face twice, and windows tie everywhere.
TEST_CASE("OverFacesThatAreLinesExactPathsAreAsLongAsTheirDistances") {
  const Surface thin({{{0, 0, 0}, {2, 0, 0}, {2, 1e-9, 0}}, {{1, 2, 0}, {2, 0, 1}}});
  const SurfacePoint end = thin.on(1, {0.25, 0.25, 0.5});
  for (const Method method : {Method::exact, Method::chen_han}) {
    const Field field = thin.field_by(method, {{thin.on(1, {0, 7.0 / 12, 5.0 / 12}), 0}});
    const auto path = thin.path(field, end);
    REQUIRE(path);
    CHECK(path->length == doctest::Approx(2.0 / 3).epsilon(1e-9));
  }
  std::mt19937 random(fixtures::test_seed());
  PathsOnLines all;
  for (int round = 0; round < 400; ++round)
    all.add(fixtures::heap_on_a_line(random, 0), random, 5, 5);
  CHECK(all.count > 1500);
  CHECK(all.shorter == 0);
  CHECK(all.longer == 0);
}

// A face so low has sides of which its products hold half of the digits.
TEST_CASE("OverFacesThatAreNearlyLinesExactPathsAreAsLongAsTheirDistances") {
  std::mt19937 random(fixtures::test_seed());
  PathsOnLines all;
  for (int round = 0; round < fixtures::all_or(6000, 1000); ++round) {
    const double off = fixtures::any_scale(random, round % 2 == 0 ? -10 : -13, -7.5);
    CAPTURE(off);
    all.add(fixtures::heap_on_a_line(random, off), random, 5, 0);
  }
  CHECK(all.count > fixtures::all_or(25'000, 4'000));
  // Some are off by a few 1e-9 still: one in 250,000.
  CHECK(all.shorter + all.longer <= 3);
}
