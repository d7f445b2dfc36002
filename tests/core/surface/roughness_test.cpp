// Which surfaces count as rough, and which have faces as large as they are.
#include "core/surface/roughness.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>

#include "core/mesh/shapes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

// Rows of a plane folded up and down, by so many degrees at each row's edge.
TriangleSoup pleated(double degrees, std::uint32_t side) {
  TriangleSoup soup = shapes::plane(side, side);
  const double half = degrees / 2 / 180 * std::numbers::pi;
  for (Vec3& p : soup.positions) {
    const auto row = static_cast<std::uint32_t>(std::lround(p.y));
    p = {p.x, p.y * std::cos(half), row % 2 == 0 ? 0 : std::sin(half)};
  }
  return soup;
}

}  // namespace

TEST_CASE("RoughIsWhatBendsByMoreThanFifteenDegrees") {
  // One inner edge in three is between two rows.
  CHECK(!Surface(pleated(0, 40)).adjacency().is_rough());
  CHECK(!Surface(pleated(14, 40)).adjacency().is_rough());
  CHECK(Surface(pleated(16, 40)).adjacency().is_rough());
  // More edges than are looked at.
  CHECK(!Surface(pleated(14, 120)).adjacency().is_rough());
  CHECK(Surface(pleated(16, 120)).adjacency().is_rough());
  CHECK(!Surface(shapes::icosphere(4)).adjacency().is_rough());
}

TEST_CASE("RoughnessTakesNoNoticeOfWinding") {
  std::mt19937 random(fixtures::test_seed());
  for (const double degrees : {10.0, 20.0, 170.0}) {
    CAPTURE(degrees);
    TriangleSoup soup = pleated(degrees, 30);
    const bool is_rough = Surface(soup).adjacency().is_rough();
    CHECK(is_rough == (degrees > 15));
    for (auto& face : soup.faces) {
      if (random() % 2 == 0) std::swap(face[0], face[1]);
    }
    CHECK(Surface(soup).adjacency().is_rough() == is_rough);
  }
}

TEST_CASE("LargeFacesAreLongBesideTheWholeSurface") {
  CHECK(Surface(shapes::icosphere(0)).adjacency().has_large_faces());
  CHECK(!Surface(shapes::icosphere(4)).adjacency().has_large_faces());
  CHECK(!Surface(shapes::plane(30, 30)).adjacency().has_large_faces());
  // One triangle beside many small ones: of half their area, then of a hundredth.
  for (const bool is_large : {true, false}) {
    CAPTURE(is_large);
    TriangleSoup soup = shapes::plane(30, 30);
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    const double width = is_large ? 29 : 0.5;
    soup.positions.insert(soup.positions.end(), {{0, 0, 5}, {29, 0, 5}, {0, width, 5}});
    soup.faces.push_back({first, first + 1, first + 2});
    CHECK(Surface(soup).adjacency().has_large_faces() == is_large);
  }
}
