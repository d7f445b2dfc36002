// The solids of modelling programs, whose poles are rings as wide as rounding: everything
// that goes over them comes to an end, and what it says is so.
#include "tests/fixtures/modelling_primitives.h"

#include <doctest/doctest.h>

#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Primitive;
using fixtures::Solid;
using fixtures::Surface;

TEST_CASE("ModellingPrimitivesHaveThePolesThatTheyName") {
  for (const Primitive& primitive : fixtures::modelling_primitives(fixtures::test_seed())) {
    CAPTURE(fixtures::name_of(primitive));
    const TriangleSoup soup = fixtures::soup_of(primitive);
    const Surface surface(soup);
    CHECK(surface.mesh().vertex_count() >= 4);
    CHECK(surface.mesh().vertex_count() <= 120);
    if (primitive.solid == Solid::icosphere) continue;
    double nearest = kUnreached;  // to the axis, of the vertices that are not on it
    for (const Vec3 p : soup.positions) {
      if (const double r = std::hypot(p.x, p.y); r > 0) nearest = std::min(nearest, r);
    }
    const double rounding = primitive.float32 ? 1e-5 : 1e-12;
    if (primitive.pole > 0) {
      CHECK(std::abs(nearest - primitive.pole) <= rounding * primitive.pole);
    } else {
      CHECK(nearest > 1e-3);
    }
  }
}
