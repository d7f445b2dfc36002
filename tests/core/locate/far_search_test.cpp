// Points far from a mesh: the closest point is right from any distance, and costs as little as
// from nearby.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/locate/closest_point.h"
#include "core/mesh/shapes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

using Long = long double;

// How much farther from the origin than from x the far point D u is, and what tells points apart
// from so far away: |D u - x| - D, in extended precision and without cancellation.
Long nearer_by(Vec3 u, Long away, Vec3 x) {
  const Long length = std::sqrt(static_cast<Long>(u.x) * u.x + static_cast<Long>(u.y) * u.y +
                                static_cast<Long>(u.z) * u.z);
  const Long along =
      (static_cast<Long>(u.x) * x.x + static_cast<Long>(u.y) * x.y + static_cast<Long>(u.z) * x.z) /
      length;
  const Long x2 =
      static_cast<Long>(x.x) * x.x + static_cast<Long>(x.y) * x.y + static_cast<Long>(x.z) * x.z;
  return x2 / (2 * away) - along;
}

struct Named {
  std::string name;
  TriangleSoup soup;
};

std::vector<Named> meshes(std::mt19937& random) {
  TriangleSoup dust;  // triangles anywhere, large beside small
  std::uniform_real_distribution<double> place(-1, 1);
  for (std::uint32_t f = 0; f < 3000; ++f) {
    const Vec3 at{place(random), place(random), place(random)};
    const double size = std::exp2(10 * place(random) - 10);
    for (std::uint32_t c = 0; c < 3; ++c) {
      dust.positions.push_back(at + size * Vec3{place(random), place(random), place(random)});
    }
    dust.faces.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  return {{"plane", shapes::plane(100, 100)},
          {"icosphere", shapes::icosphere(5)},
          {"terrain", shapes::terrain(100, 5, 1)},
          {"torus_knot", shapes::torus_knot(200, 40, 0.5)},
          {"dust", dust}};
}

Vec3 drawn_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vec3 u{normal(random), normal(random), normal(random)};
  // Along an axis, in a plane of two, or anywhere: what is flat is seen from straight above too.
  switch (random() % 4) {
    case 0:
      u.x = u.y = 0;
      break;
    case 1:
      u.y = u.z = 0;
      break;
    case 2:
      u.z = 0;
      break;
    default:
      break;
  }
  return (1 / norm(u)) * u;
}

}  // namespace

TEST_CASE("FarPointsHaveTheClosestPointAndLookAtFewFaces") {
  std::mt19937 random(test_seed());
  std::uniform_real_distribution<double> exponent(0.7, 55);
  for (const Named& mesh : meshes(random)) {
    const Surface surface(mesh.soup);
    const ClosestPointIndex index(surface.shared());
    const Box box = surface.mesh().box();
    const Vec3 middle = 0.5 * (box.min + box.max);
    const double size = norm(box.max - box.min);
    for (int i = 0; i < 60; ++i) {
      const Vec3 u = drawn_direction(random);
      const double away = size * std::pow(10, exponent(random));
      CAPTURE(mesh.name);
      CAPTURE(away);
      CAPTURE(u.x);
      CAPTURE(u.y);
      CAPTURE(u.z);
      int asked = 0;
      const auto found = index.closest(middle + away * u, Cancel([&] {
                                         ++asked;
                                         return false;
                                       }));
      REQUIRE(found.has_value());
      // It is asked once in 4096 faces: so all of them are looked at only where there are no more.
      CHECK(asked == 0);
      // No vertex is nearer, and no point of a face can be nearer than its vertices by more than
      // the bend of a sphere of this radius over the mesh.
      Long least = INFINITY;
      for (const Vec3& p : surface.mesh().positions()) {
        least = std::min(least, nearer_by(u, away, p - middle));
      }
      const Long own = nearer_by(u, away, position_of(surface.mesh(), found->point) - middle);
      CHECK(own <= least + 1e-14L * size);
      CHECK(own >= least - static_cast<Long>(size) * size / away - 1e-14L * size);
    }
  }
}

TEST_CASE("PointsAtMiddleDistancesVsAllFaces") {
  std::mt19937 random(test_seed());
  std::uniform_real_distribution<double> exponent(-1, 4);
  for (const Named& mesh : meshes(random)) {
    const Surface surface(mesh.soup);
    const ClosestPointIndex index(surface.shared());
    const Box box = surface.mesh().box();
    const double size = norm(box.max - box.min);
    for (int i = 0; i < 20; ++i) {
      const double away = size * std::pow(10, exponent(random));
      const Vec3 from = 0.5 * (box.min + box.max) + away * drawn_direction(random);
      const ClosestPoint found = index.closest(from);
      // No vertex is nearer, nor any of some points inside faces.
      double least = INFINITY;
      for (int sample = 0; sample < 40; ++sample) {
        const std::uint32_t f = random() % surface.mesh().face_count();
        std::uniform_real_distribution<double> weight(0, 1);
        const SurfacePoint point =
            point_on_face(surface.adjacency(), f, {weight(random), weight(random), weight(random)});
        least = std::min(least, distance(from, position_of(surface.mesh(), point)));
      }
      for (const Vec3& p : surface.mesh().positions()) least = std::min(least, distance(from, p));
      CAPTURE(mesh.name);
      CAPTURE(away);
      CHECK(found.distance <= least * (1 + 1e-15));
    }
  }
}

// A millionth of a size nearer to the mesh, seen from a million sizes away: single precision
// does not tell them apart.
TEST_CASE("AFootBetweenVerticesIsFoundFromFarAway") {
  const Surface plane(shapes::plane(50, 50));
  const ClosestPointIndex index(plane.shared());
  for (const double height : {10.0, 1e3, 1e6, 1e9}) {
    const ClosestPoint found = index.closest({12.25, 17.5, height});
    const Vec3 at = position_of(plane.mesh(), found.point);
    CHECK(at.x == doctest::Approx(12.25).epsilon(1e-9));
    CHECK(at.y == doctest::Approx(17.5).epsilon(1e-9));
    CHECK(found.distance == height);
  }
}

TEST_CASE("ASearchEndsWhenItIsCancelled") {
  // From the middle of a sphere each face is looked at.
  const Surface sphere(shapes::icosphere(5));
  const ClosestPointIndex index(sphere.shared());
  int asked = 0;
  const auto found = index.closest({0, 0, 0}, Cancel([&] { return ++asked == 2; }));
  REQUIRE_FALSE(found.has_value());
  CHECK(found.error().code == ErrorCode::cancelled);
  CHECK(asked == 2);

  // A ray meets each of many faces on one edge.
  TriangleSoup book{{{0, -1, 0}, {0, 1, 0}}, {}};
  for (std::uint32_t page = 0; page < 10'000; ++page) {
    book.positions.push_back({1, 0, 1e-5 * page});
    book.faces.push_back({0, 1, page + 2});
  }
  const Surface pages(book);
  const ClosestPointIndex of_pages(pages.shared());
  const auto hit = of_pages.first_hit({-5, 0, 0}, {1, 0, 0}, Cancel([] { return true; }));
  REQUIRE_FALSE(hit.has_value());
  CHECK(hit.error().code == ErrorCode::cancelled);
}
