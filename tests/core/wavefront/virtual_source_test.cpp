#include "core/wavefront/virtual_source.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace geodesic;

namespace {

// The apex (x, y) over a base of length `base` on the x axis.
UnfoldedApex over(double base, double x, double y) {
  return {x * base, (base - x) * base, y * base, x * x + y * y, (x - base) * (x - base) + y * y};
}

}  // namespace

TEST_CASE("LineThatCrossesTheBaseIsCaseA") {
  // Source at (1, -3); base from (0, 0) to (4, 0); apex at (2, 3).
  const Arrival a = arrive(std::hypot(1, 3), std::hypot(3, 3), over(4, 2, 3));
  CHECK(a.which == Fig4::a);
  CHECK(a.distance == doctest::Approx(std::hypot(1, 6)).epsilon(1e-14));
  CHECK(a.crossing == doctest::Approx(1.5 / 4).epsilon(1e-14));
}

TEST_CASE("LineLeftOfTheBaseIsCaseB") {
  // Source at (-4, -1), far to the left; the straight line would pass outside p.
  const Arrival b = arrive(std::hypot(4, 1), std::hypot(8, 1), over(4, 1, 3));
  CHECK(b.which == Fig4::b);
  CHECK(b.distance == doctest::Approx(std::hypot(4, 1) + std::hypot(1, 3)).epsilon(1e-14));
}

TEST_CASE("LineRightOfTheBaseIsCaseC") {
  const Arrival c = arrive(std::hypot(8, 1), std::hypot(4, 1), over(4, 3, 3));
  CHECK(c.which == Fig4::c);
  CHECK(c.distance == doctest::Approx(std::hypot(4, 1) + std::hypot(1, 3)).epsilon(1e-14));
}

TEST_CASE("SourceAtAnEndOfTheBaseReachesTheApexAlongTheSide") {
  const Arrival at_p = arrive(0, 4, over(4, 1, 3));
  CHECK(at_p.distance == doctest::Approx(std::hypot(1, 3)).epsilon(1e-14));
  const Arrival at_q = arrive(4, 0, over(4, 1, 3));
  CHECK(at_q.distance == doctest::Approx(std::hypot(3, 3)).epsilon(1e-14));
}

TEST_CASE("CirclesThatDoNotMeetBendAtTheCloserEnd") {
  const Arrival b = arrive(1, 10, over(4, 1, 3));
  CHECK(b.which == Fig4::b);
  CHECK(b.distance == doctest::Approx(1 + std::hypot(1, 3)).epsilon(1e-14));
  const Arrival c = arrive(10, 1, over(4, 1, 3));
  CHECK(c.which == Fig4::c);
}

TEST_CASE("SourceOnTheLineOfTheBaseLosesNoDigits") {
  // On the base's line the circles only touch: the naive formula loses half of
  // the digits here.
  const double far = 1e6;
  const Arrival b = arrive(far, far + 1, over(1, 1.5, 0.25));
  CHECK(b.distance == doctest::Approx(far + std::hypot(1.5, 0.25)).epsilon(1e-14));
}

TEST_CASE("AnApexOnTheBaseIsReachedStraight") {
  const Arrival a = arrive(3, 3, over(4, 2, 0));
  CHECK(a.which == Fig4::a);
  CHECK(a.distance == doctest::Approx(std::sqrt(5)).epsilon(1e-14));
  CHECK(a.crossing == doctest::Approx(0.5));
}

TEST_CASE("EverythingOnOneLineIsFinite") {
  const Arrival flat = arrive(1, 5, over(4, 6, 0));
  CHECK(flat.distance == doctest::Approx(7));
  const Arrival no_base = arrive(2, 3, UnfoldedApex{0, 0, 0, 4, 4});
  CHECK(no_base.distance == doctest::Approx(4));
}
