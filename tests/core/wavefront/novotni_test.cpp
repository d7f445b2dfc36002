// Novotni and Klein 2002: where it equals Tang et al.'s wavefront, and where the
// two cases that it lacks make it too short.
#include "core/wavefront/novotni.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/mesh/shapes.h"
#include "tests/fixtures/among_squares.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

TEST_CASE("NovotniGoesStraightPastTheEndOfTheBase") {
  // Base from (0, 0) to (4, 0), apex (1, 3), source (-4, -1): the line passes left of p.
  const UnfoldedApex apex{4, 12, 12, 10, 18};
  const double dp = std::hypot(4, 1);
  const double dq = std::hypot(8, 1);
  CHECK(arrive(dp, dq, apex).which == Fig4::b);
  CHECK(arrive_without_cases(dp, dq, apex).distance ==
        doctest::Approx(std::hypot(5, 4)).epsilon(1e-14));
  CHECK(arrive_without_cases(dp, dq, apex).distance < arrive(dp, dq, apex).distance);
}

TEST_CASE("NovotniEqualsTheWavefrontWhereEveryLineCrossesItsBase") {
  const UnfoldedApex apex{8, 8, 12, 13, 13};
  const Arrival with = arrive(3, 3.5, apex);
  REQUIRE(with.which == Fig4::a);
  CHECK(arrive_without_cases(3, 3.5, apex).distance == with.distance);
}

TEST_CASE("NovotniCutsTheCornersOfAHole") {
  const shapes::Hole hole{8, 8, 14};
  const Surface surface(shapes::plane_with_holes(30, 30, std::span(&hole, 1)));
  const std::vector<fixtures::Square> squares{{8, 8, 22, 22}};
  const auto distances = [&](Method method) {
    return surface.in_source_order(surface.field_by(method, {Source{surface.at(0), 0}}));
  };
  const auto novotni = distances(Method::novotni);
  const auto wavefront = distances(Method::wavefront);
  double least_novotni = 0;
  double least_wavefront = 0;
  for (std::uint32_t v = 1; v < novotni.size(); ++v) {
    if (!std::isfinite(novotni[v])) continue;
    const double x = v % 30;
    const double y = v / 30;
    const double truth = fixtures::shortest_among(squares, {0, 0}, {x, y});
    least_novotni = std::min(least_novotni, novotni[v] / truth - 1);
    least_wavefront = std::min(least_wavefront, wavefront[v] / truth - 1);
    CHECK(novotni[v] <= wavefront[v] * (1 + 1e-12));
  }
  MESSAGE("behind a hole, below the truth by up to: novotni ", -100 * least_novotni,
          " %, wavefront ", -100 * least_wavefront, " %");
  CHECK(least_novotni < -0.01);
  CHECK(least_wavefront > -0.01);
}
