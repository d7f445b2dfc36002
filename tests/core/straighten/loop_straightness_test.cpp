// How far closed paths are from straight, against angles that are known.
#include "core/straighten/loop_straightness.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <numbers>

#include "core/mesh/shapes.h"
#include "tests/core/straighten/loops.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using namespace geodesic::loops;
using fixtures::Surface;
using std::numbers::pi;

TEST_CASE("AStraightnessIsWhatThePathLacks") {
  // Round a square of a plane: a right angle at each corner.
  const Surface surface(shapes::plane(5, 5));
  const auto square = round_by(surface, {6, 8, 18, 16});
  REQUIRE(square);
  const auto straightness = straightness_of_loop(surface.adjacency(), *square, Cancel());
  REQUIRE(straightness);
  CHECK(straightness->turn == doctest::Approx(pi / 2));
  CHECK(straightness->lack == doctest::Approx(pi / 2));
  // Over the tip of a cube, straight ahead is half of 270 degrees.
  const Surface tip(
      {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}});
  const auto over = round_by(tip, {0, 1, 2});
  REQUIRE(over);
  const auto at_tip = straightness_of_loop(tip.adjacency(), *over, Cancel());
  REQUIRE(at_tip);
  // 90 degrees at the tip, of 135; at the boundary 45 + 45 on the one side that is there.
  CHECK(at_tip->lack == doctest::Approx(3 * pi / 4));
}

// Round a face of an octahedron there are 60 degrees on one side of each corner, of 240 in all; and
// so there are where other faces touch its corners, which come first in the mesh.
TEST_CASE("FacesThatTouchAVertexAloneDoNotCountThere") {
  const TriangleSoup octahedron{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
      {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2}, {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}}};
  TriangleSoup touched = octahedron;
  for (std::uint32_t v = 0; v < 3; ++v) {
    const auto next = static_cast<std::uint32_t>(touched.positions.size());
    const Vec3 p = touched.positions[v];
    touched.positions.push_back(3 * p + Vec3{0.1, 0, 0});
    touched.positions.push_back(3 * p + Vec3{0, 0.1, 0.1});
    touched.faces.insert(touched.faces.begin(), {v, next, next + 1});
  }
  for (const TriangleSoup& soup : {octahedron, touched}) {
    const Surface surface(soup);
    const auto loop = round_by(surface, {0, 1, 2});
    REQUIRE(loop);
    const auto straightness = straightness_of_loop(surface.adjacency(), *loop, Cancel());
    REQUIRE(straightness);
    CHECK(straightness->is_known);
    CHECK(straightness->turn == doctest::Approx(pi / 3));
    CHECK(straightness->lack == doctest::Approx(2 * pi / 3));
  }
}
