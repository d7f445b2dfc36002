// Straight ahead over faces without width, and from right beside vertices: the line of the plane.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "tests/fixtures/straightest.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/uneven_planes.h"

using namespace geodesic;
using fixtures::End;
using fixtures::end_of;
using fixtures::go;
using fixtures::RandomMesh;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

// An axis of space for each of the plane's: lines are lines to the last bit, or but for rounding.
void turn_plane(RandomMesh& random, TriangleSoup& soup) {
  const double a = random.unit() < 0.3 ? 0 : 6 * random.unit();
  const Vec3 x{std::cos(a), std::sin(a) * 0.6, std::sin(a) * 0.8};
  const Vec3 y{-std::sin(a), std::cos(a) * 0.6, std::cos(a) * 0.8};
  for (Vec3& p : soup.positions) p = p.x * x + p.y * y;
}

// At a vertex, on a side, in a face with a width or without one.
SurfacePoint some_point(RandomMesh& random, const Surface& surface) {
  const std::uint32_t face = random.below(surface.mesh().source_face_count());
  std::array<double, 3> bary{random.unit() + 0.01, random.unit() + 0.01, random.unit() + 0.01};
  const double kind = random.unit();
  if (kind < 0.4) bary[random.below(3)] = 0;
  if (kind < 0.2) {
    bary = {0, 0, 0};
    bary[random.below(3)] = 1;
  }
  return surface.on(face, bary);
}

// Away from the boundary by as much as it may be missed by.
bool is_well_inside(const Surface& surface, const SurfacePoint& point) {
  for (const SurfacePoint& place : in_all_faces(surface.adjacency(), point)) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge side = halfedge(place.face, c);
      if (surface.adjacency().ring(side) == side && place.bary[previous_corner(c)] < 1e-3) {
        return false;
      }
    }
  }
  return true;
}

void check_goes_straight(const Surface& surface, const SurfacePoint& from, const SurfacePoint& to) {
  if (!is_well_inside(surface, from) || !is_well_inside(surface, to)) return;
  const Vec3 way = position_of(surface.mesh(), to) - position_of(surface.mesh(), from);
  if (norm(way) < 0.1) return;
  const auto there = go(surface, from, way, norm(way));
  CHECK(there.end == End::length);
  CHECK(distance(end_of(there), position_of(surface.mesh(), to)) <= 1e-8);
  CHECK(distance(there.direction_at_end, (1 / norm(way)) * way) <= 1e-8);
}

}  // namespace

TEST_CASE("StraightAheadOverFacesWithoutWidthIsTheLineOfThePlane") {
  for (std::uint32_t round = 0; round < 40; ++round) {
    CAPTURE(round);
    RandomMesh random(test_seed() + round);
    TriangleSoup soup = fixtures::uneven_plane(random, 4 + random.below(4));
    for (std::uint32_t i = 0; i <= random.below(4); ++i) {
      fixtures::put_flat_faces_in(random, soup);
    }
    turn_plane(random, soup);
    const Surface surface(soup);
    // Two sides of faces that lie on one line may have both ends in common.
    if (surface.adjacency().report().edges_non_manifold > 0) continue;
    for (std::uint32_t i = 0; i < 30; ++i) {
      CAPTURE(i);
      check_goes_straight(surface, some_point(random, surface), some_point(random, surface));
    }
  }
}

TEST_CASE("StraightAheadFromRightBesideAVertexIsTheLineOfThePlane") {
  for (std::uint32_t round = 0; round < 40; ++round) {
    CAPTURE(round);
    RandomMesh random(test_seed() + round);
    TriangleSoup soup = fixtures::uneven_plane(random, 4 + random.below(4));
    turn_plane(random, soup);
    const Surface surface(soup);
    for (std::uint32_t i = 0; i < 30; ++i) {
      CAPTURE(i);
      std::array<double, 3> bary{};
      for (double& weight : bary) {
        weight = random.unit() < 0.2 ? 0 : std::pow(10, -6 - 10 * random.unit());
      }
      bary[random.below(3)] = 1;
      const SurfacePoint from = surface.on(random.below(surface.mesh().source_face_count()), bary);
      check_goes_straight(surface, from, some_point(random, surface));
    }
  }
}
