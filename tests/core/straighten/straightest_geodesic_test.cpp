#include "core/straighten/straightest_geodesic.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/straightest.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/tube.h"

using namespace geodesic;
using fixtures::End;
using fixtures::end_of;
using fixtures::go;
using fixtures::size_of;
using fixtures::Surface;
using fixtures::turn;
using std::numbers::pi;

namespace {

// A prism of `around` sides without lids, of circumradius 1: row j at the height j.
TriangleSoup prism(std::uint32_t around, std::uint32_t rows) {
  return fixtures::tube(around, rows - 1, rows - 1);
}

// The cube [0, 1]^3; vertex number x + 2 y + 4 z.
TriangleSoup cube() {
  TriangleSoup soup;
  for (int i = 0; i < 8; ++i)
    soup.positions.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2)});
  const auto square = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    soup.faces.push_back({a, b, c});
    soup.faces.push_back({a, c, d});
  };
  square(0, 2, 3, 1);
  square(4, 5, 7, 6);
  square(0, 1, 5, 4);
  square(2, 6, 7, 3);
  square(0, 4, 6, 2);
  square(1, 3, 7, 5);
  return soup;
}

TriangleSoup moebius_strip(std::uint32_t n) {
  TriangleSoup strip;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double u = 2 * pi * i / n;
    for (const double w : {-0.3, 0.3}) {
      const double r = 1 + w * std::cos(u / 2);
      strip.positions.push_back({r * std::cos(u), r * std::sin(u), w * std::sin(u / 2)});
    }
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    const std::uint32_t c = last ? 1 : 2 * i + 2;
    const std::uint32_t d = last ? 0 : 2 * i + 3;
    strip.faces.push_back({2 * i, c, 2 * i + 1});
    strip.faces.push_back({2 * i + 1, c, d});
  }
  return strip;
}

}  // namespace

TEST_CASE("OnAPlaneItIsALine") {
  int tried = 0;
  for (const TriangleSoup& soup :
       {shapes::plane(40, 40), shapes::plane(40, 40, shapes::Diagonal::falling),
        shapes::terrain(40, 0, 3), shapes::shuffled(shapes::terrain(40, 0, 4), 5)}) {
    const Surface surface(soup);
    const std::vector<SurfacePoint> starts{
        surface.at(20 * 40 + 20), surface.on(1521, {0.2, 0.3, 0.5}),
        surface.on(1521, {0, 0.4, 0.6}), surface.on(1523, {0.5, 0.5, 0}),
        surface.on(1523, {0.25, 0, 0.75})};
    for (const SurfacePoint& from : starts) {
      const Vec3 start = position_of(surface.mesh(), from);
      // In shuffled meshes they are anywhere.
      if (std::abs(start.x - 20) > 5 || std::abs(start.y - 20) > 5) continue;
      for (int i = 0; i < 24; ++i) {
        const double u = pi * i / 12 + (i % 2) * 0.01;
        const Vec3 direction{std::cos(u), std::sin(u), 0};
        // Whatever points off the plane is taken away.
        const auto there = go(surface, from, 7.5 * direction + Vec3{0, 0, i * 0.5}, 14);
        CHECK(there.end == End::length);
        CHECK(distance(end_of(there), start + 14.0 * direction) <= 1e-12);
        CHECK(distance(there.direction_at_end, direction) <= 1e-12);
        ++tried;
      }
    }
  }
  CHECK(tried >= 15 * 24);
}

TEST_CASE("AnAngleIsMeasuredFromTheFirstEdge") {
  const TriangleSoup soup = shapes::terrain(20, 0, 6);
  const Surface surface(soup);
  const std::uint32_t source_face = 361;
  const auto& t = soup.faces[source_face];
  const Vec3 along = soup.positions[t[1]] - soup.positions[t[0]];
  const Vec3 third = soup.positions[t[2]] - soup.positions[t[0]];
  const double towards_third = cross(along, third).z > 0 ? 1 : -1;
  for (const auto& bary : {std::array<double, 3>{0.2, 0.3, 0.5}, {0, 0.4, 0.6}, {0.5, 0.5, 0}}) {
    const SurfacePoint from = surface.on(source_face, bary);
    for (int i = -3; i < 20; ++i) {
      const double angle = pi * i / 8 + 0.05;
      const double u = std::atan2(along.y, along.x) + towards_third * angle;
      const Vec3 direction{std::cos(u), std::sin(u), 0};
      const auto there = turn(surface, from, angle, 6);
      REQUIRE(there.end == End::length);
      CHECK(distance(end_of(there), position_of(surface.mesh(), from) + 6.0 * direction) <= 1e-12);
    }
  }
  // At a vertex, from the first face's edge from the vertex's corner to the next.
  const std::uint32_t v = surface.vertex(190);
  const std::uint32_t corner = surface.adjacency().corners(v).front();
  const auto& vertex = surface.adjacency().face(face_of(corner)).vertex;
  const auto position = [&](std::uint32_t c) { return surface.mesh().positions()[vertex[c]]; };
  const Vec3 centre = position(corner_of(corner));
  const Vec3 first = position(next_corner(corner_of(corner))) - centre;
  const Vec3 second = position(previous_corner(corner_of(corner))) - centre;
  const double way = cross(first, second).z > 0 ? 1 : -1;
  for (int i = -20; i < 40; ++i) {
    const double angle = pi * i / 8 + 0.05;
    const double u = std::atan2(first.y, first.x) + way * angle;
    const auto there = turn(surface, surface.at(190), angle, 6);
    CHECK(distance(end_of(there), centre + 6.0 * Vec3{std::cos(u), std::sin(u), 0}) <= 1e-12);
  }
}

TEST_CASE("OnAPrismItIsAHelix") {
  const std::uint32_t around = 12;
  const Surface surface(prism(around, 30));
  // Into the first side at the slope of one row per side, three and a half times round.
  const double side = 2 * std::sin(pi / around);
  const SurfacePoint from = surface.on(0, {0.5, 0.5, 0});  // the middle of a bottom edge
  const Vec3 start = position_of(surface.mesh(), from);
  const Vec3 along =
      surface.mesh().positions()[surface.vertex(1)] - surface.mesh().positions()[surface.vertex(0)];
  const double sides = 42;
  const double height = 21;
  const auto there = go(surface, from, (sides * side / norm(along)) * along + Vec3{0, 0, height},
                        std::hypot(sides * side, height));
  CHECK(there.end == End::length);
  // Half a turn from the start.
  CHECK(distance(end_of(there), Vec3{-start.x, -start.y, height}) <= 1e-12);
}

TEST_CASE("OverACornerOfACubeTheAnglesAreEqual") {
  const Surface surface(cube());
  // Down the diagonal of the top into the corner (1, 1, 1), where the angles add up to
  // 3 pi / 2: on down the edge, 3 pi / 4 from either side.
  const auto by_diagonal = go(surface, surface.at(4), {1, 1, 0}, std::sqrt(2) + 0.5);
  CHECK(by_diagonal.end == End::length);
  CHECK(distance(end_of(by_diagonal), {1, 1, 0.5}) <= 1e-14);
  CHECK(distance(by_diagonal.direction_at_end, {0, 0, -1}) <= 1e-14);
  // Along an edge into it: down the diagonal of the opposite side.
  const auto by_edge = go(surface, surface.at(5), {0, 1, 0}, 1 + std::sqrt(0.5));
  CHECK(distance(end_of(by_edge), {0.5, 1, 0.5}) <= 1e-14);
  // Round a cube in a plane one comes back.
  const auto round = go(surface, surface.on(2, {0.25, 0.5, 0.25}), {1, 0, 0}, 4);
  CHECK(distance(end_of(round), round.path.points.front().position) <= 1e-14);
}

TEST_CASE("AGreatCircleOfAFineSphereNearlyCloses") {
  const Surface surface(shapes::icosphere(5));
  for (int i = 0; i < 6; ++i) {
    const auto round = turn(surface, surface.on(1000, {0.3, 0.3, 0.4}), 0.3 + i, 2 * pi);
    CHECK(round.end == End::length);
    const Vec3 start = round.path.points.front().position;
    CHECK(distance(end_of(round), start) < 0.05);
    const auto half = turn(surface, surface.on(1000, {0.3, 0.3, 0.4}), 0.3 + i, pi);
    CHECK(distance(end_of(half), -1.0 * start) < 0.05);
  }
}

TEST_CASE("BackAgainLeadsToTheStart") {
  std::mt19937 random(3);
  for (const TriangleSoup& soup :
       {shapes::terrain(40, 4, 1), shapes::torus_knot(120, 12, 0.4), shapes::icosphere(3),
        shapes::shuffled(shapes::saddle(30, 9), 4), moebius_strip(60)}) {
    const Surface surface(soup);
    int there_and_back = 0;
    for (int i = 0; i < 40; ++i) {
      const auto face = static_cast<std::uint32_t>(random() % soup.faces.size());
      const double length = 0.2 * size_of(surface);
      const auto there = turn(surface, surface.on(face, {0.3, 0.2, 0.5}), 0.37 * i, length);
      if (there.end != End::length) continue;
      ++there_and_back;
      const auto back =
          go(surface, there.path.points.back().point, -1.0 * there.direction_at_end, length);
      CHECK(distance(end_of(back), there.path.points.front().position) <= 1e-9 * length);
    }
    CHECK(there_and_back >= 5);
  }
}

TEST_CASE("TheSeamOfAMoebiusStripIsLikeAnyOtherPlace") {
  // Behind the seam the faces are wound the other way. The middle line is a circle,
  // and nearly straight; a wrong turn at the seam would lead back or to the rim.
  const std::uint32_t n = 200;
  const Surface surface(moebius_strip(n));
  for (const std::uint32_t segment : {10U, n - 3}) {
    const double u = 2 * pi * segment / n;
    const double length = 0.25;
    const auto there =
        go(surface, surface.on(2 * segment, {0.5, 0, 0.5}), {-std::sin(u), std::cos(u), 0}, length);
    CHECK(there.end == End::length);
    const Vec3 expected{std::cos(u + length), std::sin(u + length), 0};
    CHECK(distance(end_of(there), expected) < 0.2 * length);
  }
}

TEST_CASE("FlippedFacesTurnNothing") {
  TriangleSoup soup = shapes::terrain(30, 5, 8);
  const Surface before(soup);
  for (std::size_t f = 0; f < soup.faces.size(); f += 3) {
    std::swap(soup.faces[f][1], soup.faces[f][2]);
  }
  const Surface after(soup);
  for (int i = 0; i < 12; ++i) {
    const Vec3 direction{std::cos(i), std::sin(i), 0.1 * i};
    CHECK(distance(end_of(go(before, before.at(15 * 30 + 15), direction, 12)),
                   end_of(go(after, after.at(15 * 30 + 15), direction, 12))) <= 1e-10);
  }
}

TEST_CASE("HugeAndTinyMeshesTraceAlike") {
  const TriangleSoup unit = shapes::terrain(16, 3, 1);
  const Surface one(unit);
  const auto expected = end_of(go(one, one.at(100), {1, 0.3, 0}, 5));
  for (const double scale : {0x1p-130, 0x1p130}) {
    TriangleSoup soup = unit;
    for (Vec3& p : soup.positions) p = scale * p;
    const Surface surface(soup);
    const auto there = straightest_geodesic(surface.adjacency(), surface.at(100), {1, 0.3, 0},
                                            5 * scale, Cancel());
    REQUIRE(there.has_value());
    CHECK(distance((1 / scale) * end_of(*there), expected) <= 1e-12);
  }
}

TEST_CASE("NeedlesAreCrossedStraight") {
  for (const double thin : {1e-3, 1e-6, 1e-9, 1e-12}) {
    TriangleSoup soup = shapes::plane(12, 12);
    for (Vec3& p : soup.positions) {
      const int column = static_cast<int>(p.x);
      p.x = column / 2 + (column % 2) * thin;
    }
    const Surface surface(soup);
    const SurfacePoint from = surface.on(2, {0.3, 0.3, 0.4});
    const Vec3 start = position_of(surface.mesh(), from);
    const Vec3 to{4.5, 7.25, 0};
    const auto there = go(surface, from, to - start, distance(start, to));
    CHECK(there.end == End::length);
    CHECK(distance(end_of(there), to) <= 1e-9);
  }
}
