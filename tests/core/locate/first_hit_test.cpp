#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "core/locate/closest_point.h"
#include "core/mesh/shapes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

struct Oracle {
  double t = kInfinity;      // of the nearest face that is surely met, in lengths of the direction
  double doubt = kInfinity;  // of the nearest that rounding may decide either way
};

// Moeller and Trumbore's test on every face: it shares nothing with the index.
Oracle by_brute_force(const Mesh& mesh, Vec3 origin, Vec3 direction) {
  constexpr double kSure = 1e-9;
  Oracle oracle;
  for (const Triangle& face : mesh.faces()) {
    const Vec3 a = mesh.positions()[face[0]];
    const Vec3 ab = mesh.positions()[face[1]] - a;
    const Vec3 ac = mesh.positions()[face[2]] - a;
    const Vec3 p = cross(direction, ac);
    const double determinant = dot(ab, p);
    if (std::abs(determinant) < 1e-12 * norm(ab) * norm(ac) * norm(direction)) continue;
    const double u = dot(origin - a, p) / determinant;
    const Vec3 q = cross(origin - a, ab);
    const double v = dot(direction, q) / determinant;
    const double t = dot(ac, q) / determinant;
    const double inside = std::min({u, v, 1 - u - v});
    if (inside > kSure && t > kSure) oracle.t = std::min(oracle.t, t);
    if (inside > -kSure && t > -kSure) oracle.doubt = std::min(oracle.doubt, t);
  }
  return oracle;
}

TriangleSoup scaled(TriangleSoup soup, double factor) {
  for (Vec3& p : soup.positions) p = factor * p;
  return soup;
}

// Every vertex, and places on every edge.
std::vector<Vec3> edges_and_vertices(const Mesh& mesh) {
  std::vector<Vec3> aims(mesh.positions().begin(), mesh.positions().end());
  for (const Triangle& t : mesh.faces()) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Vec3 a = mesh.positions()[t[c]];
      const Vec3 b = mesh.positions()[t[next_corner(c)]];
      for (const double at : {0.5, 1.0 / 3, 1e-9}) aims.push_back((1 - at) * a + at * b);
    }
  }
  return aims;
}

// Rays from a point to all edges and vertices that `counts`: how many there are, how many
// meet nothing, and how many meet only what is behind.
struct Slips {
  std::size_t rays = 0;
  std::size_t slipped = 0;
  std::size_t beyond = 0;
};
template <class Counts>
Slips slips_from(const Surface& surface, Vec3 origin, Counts counts) {
  const ClosestPointIndex index(surface.shared());
  Slips slips;
  for (const Vec3 aim : edges_and_vertices(surface.mesh())) {
    if (!counts(aim)) continue;
    ++slips.rays;
    const auto hit = index.first_hit(origin, aim - origin);
    if (!hit) ++slips.slipped;
    if (hit && hit->distance > distance(origin, aim) * (1 + 1e-9)) ++slips.beyond;
  }
  CHECK(slips.rays > 500);
  return slips;
}

}  // namespace

TEST_CASE("FirstHitVsMoellerTrumboreOnEveryFace") {
  std::size_t hits = 0;
  std::size_t misses = 0;
  for (std::uint32_t number = 0; number < 60; ++number) {
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const Mesh& mesh = surface.mesh();
    const ClosestPointIndex index(surface.shared());
    std::mt19937 random(number);
    std::uniform_real_distribution<double> unit(-1, 1);
    const Vec3 centre = 0.5 * mesh.box().min + 0.5 * mesh.box().max;
    const double size = norm(mesh.box().max - mesh.box().min);
    for (int i = 0; i < 100; ++i) {
      const Vec3 origin = centre + size * Vec3{unit(random), unit(random), unit(random)};
      const Vec3 aim = centre + 0.4 * size * Vec3{unit(random), unit(random), unit(random)};
      const Vec3 direction = std::exp2(20 * unit(random)) * (aim - origin);
      const Oracle oracle = by_brute_force(mesh, origin, direction);
      const auto hit = index.first_hit(origin, direction);
      if (oracle.doubt < oracle.t) continue;  // rounding may say either
      CAPTURE(i);
      REQUIRE(hit.has_value() == (oracle.t < kInfinity));
      ++(hit ? hits : misses);
      if (!hit) continue;
      CHECK(hit->distance == doctest::Approx(oracle.t * norm(direction)).epsilon(1e-9));
      const Vec3 at = position_of(mesh, hit->point);
      const Vec3 expected = origin + oracle.t * direction;
      CHECK(distance(at, expected) < 1e-9 * size);
    }
  }
  CHECK(hits > 1000);
  CHECK(misses > 500);
}

TEST_CASE("NoRaySlipsOutOfAClosedSurface") {
  const Surface sphere(shapes::icosphere(4));
  for (const Vec3 origin : {Vec3{0, 0, 0}, Vec3{0.1, -0.3, 0.2}, Vec3{1.0 / 3, 0, 0}}) {
    const Slips slips = slips_from(sphere, origin, [](Vec3) { return true; });
    CHECK(slips.slipped == 0);
    CHECK(slips.beyond == 0);
  }
  // From inside a tube; what is seen past a bend may be behind what was aimed at.
  const Surface knot(shapes::torus_knot(60, 12, 0.5));
  Vec3 ring{0, 0, 0};
  for (std::uint32_t v = 0; v < 12; ++v) ring = ring + knot.mesh().positions()[knot.vertex(v)];
  CHECK(slips_from(knot, 1.0 / 12 * ring, [](Vec3) { return true; }).slipped == 0);
}

TEST_CASE("NoRaySlipsThroughFromOutsideEither") {
  const Surface sphere(shapes::icosphere(4));
  for (const Vec3 origin : {Vec3{0, 0, 3}, Vec3{5, 4, -3}, Vec3{1e5, 2e5, 3e5}}) {
    const Slips slips = slips_from(sphere, origin, [&](Vec3 aim) {
      return dot(aim, origin - aim) > 0.1 * distance(origin, aim);  // on the side that is seen
    });
    CHECK(slips.slipped == 0);
    CHECK(slips.beyond == 0);
  }
  const Surface plane(shapes::plane(20, 20));
  const Slips slips = slips_from(plane, {3.7, 11, 8}, [](Vec3 aim) {
    return std::min(aim.x, aim.y) > 0.1 && std::max(aim.x, aim.y) < 18.9;  // not its border
  });
  CHECK(slips.slipped == 0);
}

TEST_CASE("ScaleByPowersOfTwoChangesNothing") {
  const TriangleSoup soup = shapes::torus_knot(40, 8, 0.5);
  const Surface surface(soup);
  const ClosestPointIndex index(surface.shared());
  for (const int power : {-100, -40, 40, 100}) {
    CAPTURE(power);
    const double factor = std::exp2(power);
    const Surface other(scaled(soup, factor));
    const ClosestPointIndex other_index(other.shared());
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::size_t hits = 0;
    for (int i = 0; i < 200; ++i) {
      const Vec3 origin{6 * unit(random), 6 * unit(random), 6 * unit(random)};
      const Vec3 direction = Vec3{2 * unit(random), 2 * unit(random), 2 * unit(random)} - origin;
      const auto hit = index.first_hit(origin, direction);
      // However long the direction is.
      const auto same = other_index.first_hit(factor * origin, std::exp2(900) * direction);
      REQUIRE(hit.has_value() == same.has_value());
      if (!hit) continue;
      ++hits;
      CHECK(same->point.face == hit->point.face);
      CHECK(same->distance == doctest::Approx(factor * hit->distance));
      CHECK(distance(position_of(other.mesh(), same->point),
                     factor * position_of(surface.mesh(), hit->point)) < 1e-12 * factor);
    }
    CHECK(hits > 50);
  }
}

TEST_CASE("RaysFromFarAwayMeetTheSideThatTheyCameFrom") {
  const Surface sphere(shapes::icosphere(4));
  const ClosestPointIndex index(sphere.shared());
  for (const double away : {5.0, 1e4, 1e9, 1e15, 1e30, 1e60}) {
    CAPTURE(away);
    for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1}}) {
      // Beside the middle, where no other than the axis' component is rounded.
      const Vec3 beside{0.01 * (1 - std::abs(axis.x)), 0.02 * (1 - std::abs(axis.y)),
                        0.03 * (1 - std::abs(axis.z))};
      const auto hit = index.first_hit(away * axis + beside, -1.0 * axis);
      REQUIRE(hit);
      const Vec3 at = position_of(sphere.mesh(), hit->point);
      CHECK(dot(at, axis) > 0.98);
      CHECK(distance(at - dot(at, axis) * axis, beside) < 1e-12);
      CHECK(hit->distance == doctest::Approx(away - dot(at, axis)));
      CHECK_FALSE(index.first_hit(away * axis + beside, axis));
      CHECK_FALSE(index.first_hit(away * axis + 200 * beside, -1.0 * axis));
    }
    if (away < 1e15) {
      const Vec3 from = away * Vec3{0.6, 0.64, 0.48};
      const auto hit = index.first_hit(from, -1.0 * from);
      REQUIRE(hit);
      CHECK(distance(position_of(sphere.mesh(), hit->point), {0.6, 0.64, 0.48}) <
            0.01 + 1e-14 * away);
    }
  }
}

TEST_CASE("BothSidesOfAFaceAreHit") {
  const Surface plane(shapes::plane(3, 3));
  const ClosestPointIndex index(plane.shared());
  for (const double height : {2.0, -2.0}) {
    const auto hit = index.first_hit({0.5, 0.25, height}, {0, 0, -3 * height});
    REQUIRE(hit);
    CHECK(hit->distance == 2);
    CHECK(position_of(plane.mesh(), hit->point) == Vec3{0.5, 0.25, 0});
    CHECK_FALSE(index.first_hit({0.5, 0.25, height}, {0, 0, height}));
    CHECK_FALSE(index.first_hit({2.1, 0.25, height}, {0, 0, -height}));
  }
}

TEST_CASE("ARayFromTheSurfaceBeginsAtItsHit") {
  const Surface plane(shapes::plane(3, 3));
  const ClosestPointIndex index(plane.shared());
  const auto hit = index.first_hit({0.5, 0.25, 0}, {1, 2, 3});
  REQUIRE(hit);
  CHECK(hit->distance == 0);
}

TEST_CASE("AHitAtAVertexIsThatVertexAndOneOnAnEdgeHasAWeightOfZero") {
  const Surface plane(shapes::plane(4, 4));
  const ClosestPointIndex index(plane.shared());
  const auto vertex = index.first_hit({1, 2, 5}, {0, 0, -1});
  REQUIRE(vertex);
  CHECK(vertex->point.vertex == plane.vertex(9));
  const auto edge = index.first_hit({1.5, 2, 5}, {0, 0, -1});
  REQUIRE(edge);
  CHECK_FALSE(edge->point.at_vertex());
  CHECK(std::count(edge->point.bary.begin(), edge->point.bary.end(), 0.0) == 1);
}

TEST_CASE("OfTwoSheetsCloserThanSinglePrecisionTellsTheFirstIsHit") {
  TriangleSoup soup = shapes::plane(6, 6);
  const TriangleSoup sheet = soup;
  for (const double height : {1e-12, -1e-12}) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (const Vec3 p : sheet.positions) soup.positions.push_back(p + Vec3{0, 0, height});
    for (const auto& t : sheet.faces) {
      soup.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  const Surface sheets(soup);
  const ClosestPointIndex index(sheets.shared());
  for (double x = 0.1; x < 5; x += 0.37) {
    for (const double side : {1.0, -1.0}) {
      const auto hit = index.first_hit({x, 5 - x, side}, {0, 0, -side});
      REQUIRE(hit);
      CHECK(std::abs(position_of(sheets.mesh(), hit->point).z - side * 1e-12) < 1e-20);
    }
  }
}

TEST_CASE("FacesWithoutAreaAreNoHitsOfTheirOwn") {
  // A lone one is never met, whichever way it is looked at.
  const Surface needle(TriangleSoup{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}});
  const ClosestPointIndex lone(needle.shared());
  CHECK_FALSE(lone.first_hit({1.5, 0, 1}, {0, 0, -1}));
  CHECK_FALSE(lone.first_hit({1, 0, 1}, {0, 0, -1}));
  CHECK_FALSE(lone.first_hit({-1, 0, 0}, {1, 0, 0}));

  // One between others joins them: what is hit there is a place on its neighbours.
  const Surface caps(fixtures::plane_with_caps(0));
  const ClosestPointIndex index(caps.shared());
  std::mt19937 random(2);
  std::uniform_real_distribution<double> along(0, 5);
  for (int i = 0; i < 300; ++i) {
    const Vec3 origin{std::floor(along(random)), along(random), 3};
    const auto hit = index.first_hit(origin, {0, 0, -1});
    REQUIRE(hit);
    CHECK(caps.adjacency().face(hit->point.face).area2 > 0.01);
    CHECK(distance(position_of(caps.mesh(), hit->point), {origin.x, origin.y, 0}) < 1e-12);
  }
}

TEST_CASE("AwkwardMeshesAreHitWhereTheyAre") {
  const Surface book(fixtures::book_of_three_pages());
  const ClosestPointIndex index(book.shared());
  const auto spine = index.first_hit({-1, 1, 1}, {1, 0, -1});
  REQUIRE(spine);
  CHECK(distance(position_of(book.mesh(), spine->point), {0, 1, 0}) < 1e-15);
  const auto twice = ClosestPointIndex(Surface(fixtures::plane_with_duplicate_faces()).shared())
                         .first_hit({0.6, 0.3, 1}, {0, 0, -1});
  REQUIRE(twice);
  CHECK(twice->distance == 1);
}
