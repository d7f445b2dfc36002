#include "core/locate/closest_point.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/mesh/shapes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

// An oracle that shares nothing with the index: a fine search over barycentric
// weights, refined about the best, face by face.
double distance_by_search(const Surface& surface, Vec3 from) {
  double least = INFINITY;
  for (const Triangle& t : surface.mesh().faces()) {
    const auto at = [&](double u, double v) {
      return u * surface.mesh().positions()[t[0]] + v * surface.mesh().positions()[t[1]] +
             (1 - u - v) * surface.mesh().positions()[t[2]];
    };
    double u = 1.0 / 3;
    double v = 1.0 / 3;
    double best = distance(from, at(u, v));
    for (double step = 0.4; step > 1e-9; step *= 0.7) {
      for (int turn = 0; turn < 3; ++turn) {
        for (int i = 0; i < 12; ++i) {
          const double a = 3.141592653589793 * i / 6;
          double nu = std::clamp(u + step * std::cos(a), 0.0, 1.0);
          double nv = std::clamp(v + step * std::sin(a), 0.0, 1.0);
          if (nu + nv > 1) {
            const double s = nu + nv;
            nu /= s;
            nv /= s;
          }
          const double d = distance(from, at(nu, nv));
          if (d < best) {
            best = d;
            u = nu;
            v = nv;
          }
        }
      }
    }
    least = std::min(least, best);
  }
  return least;
}

}  // namespace

TEST_CASE("ClosestPointVsSearch") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> somewhere(-4, 4);
  const Surface surface(shapes::torus_knot(24, 6, 0.5));
  const ClosestPointIndex index(surface.shared());
  for (int i = 0; i < 25; ++i) {
    const Vec3 from{somewhere(random), somewhere(random), somewhere(random)};
    const ClosestPoint found = index.closest(from);
    CHECK(found.distance == doctest::Approx(distance_by_search(surface, from)).epsilon(1e-5));
    CHECK(found.distance ==
          doctest::Approx(distance(from, position_of(surface.mesh(), found.point))));
  }
}

TEST_CASE("APointOnTheSurfaceIsItsOwnClosestPoint") {
  const Surface surface(shapes::terrain(30, 5, 1));
  const ClosestPointIndex index(surface.shared());
  for (std::uint32_t f = 0; f < surface.mesh().face_count(); f += 13) {
    const Vec3 at =
        position_of(surface.mesh(), point_on_face(surface.adjacency(), f, {0.2, 0.3, 0.5}));
    CHECK(index.closest(at).distance < 1e-12);
  }
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); v += 17) {
    const ClosestPoint found = index.closest(surface.mesh().positions()[v]);
    CHECK(found.distance == 0);
    CHECK(found.point.vertex == v);
  }
}

TEST_CASE("FarAwayAndHugeMeshesAreExactToo") {
  const Surface sphere(shapes::icosphere(3));
  const ClosestPointIndex index(sphere.shared());
  for (const double away : {10.0, 1e4, 1e9, 1e40}) {
    const Vec3 corner = sphere.mesh().positions()[7];
    const ClosestPoint found = index.closest(away * corner);
    CHECK(found.distance == doctest::Approx(away - 1));
    // Beyond this, rounding leaves no vertex closer than another.
    if (away < 1e12) CHECK(found.point.vertex == 7);
  }
  for (const double size : {1e-40, 1e40}) {
    TriangleSoup soup = shapes::icosphere(2);
    for (Vec3& p : soup.positions) p = size * p;
    const Surface scaled(soup);
    const ClosestPoint found = ClosestPointIndex(scaled.shared()).closest({3 * size, 0, 0});
    CHECK(found.distance == doctest::Approx(2 * size).epsilon(0.05));
  }
}

TEST_CASE("FacesWithoutAreaHaveClosestPoints") {
  const Surface surface(TriangleSoup{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}});
  const ClosestPoint found = ClosestPointIndex(surface.shared()).closest({1.5, 1, 0});
  CHECK(found.distance == doctest::Approx(1));
}
