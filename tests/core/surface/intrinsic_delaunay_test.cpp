#include "core/surface/intrinsic_delaunay.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/edges_to_flip.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;

namespace {

IntrinsicDelaunay delaunay_of(const Surface& surface) {
  auto result = IntrinsicDelaunay::build(surface.adjacency().triangulation(),
                                         surface.mesh().positions(), Cancel());
  REQUIRE(result.has_value());
  return std::move(*result);
}

double area_of(std::span<const FaceRecord> faces) {
  double sum = 0;
  for (const FaceRecord& face : faces) sum += face.area2 / 2;
  return sum;
}

// A plane with its inner vertices moved about and its long direction stretched.
TriangleSoup crooked_plane(double stretch) {
  TriangleSoup soup = shapes::terrain(12, 0, 5);
  for (Vec3& p : soup.positions) {
    p.x *= stretch;
    p.z = 0;
  }
  return soup;
}

// What must hold of any triangulation, and that nothing of the surface was lost.
void check_is_sound(const Surface& surface, const IntrinsicDelaunay& delaunay) {
  const Triangulation mesh = surface.adjacency().triangulation();
  const Triangulation cut = delaunay.triangulation();
  REQUIRE(cut.faces.size() == mesh.faces.size());
  const double area = area_of(mesh.faces);
  CHECK(std::abs(area_of(cut.faces) - area) <= 1e-9 * area);
  std::size_t boundary_before = 0;
  std::size_t boundary_after = 0;
  for (std::uint32_t f = 0; f < cut.faces.size(); ++f) {
    const FaceRecord& face = cut.faces[f];
    REQUIRE(std::set(face.vertex.begin(), face.vertex.end()).size() == 3);
    CHECK(face.area2 >= 0);
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      if (mesh.ring(h) == h) ++boundary_before;
      const Halfedge across = cut.ring(h);
      if (across == h) {
        ++boundary_after;
        continue;
      }
      const FaceRecord& other = cut.faces[face_of(across)];
      const std::uint32_t o = corner_of(across);
      const std::set<std::uint32_t> ends{face.vertex[c], face.vertex[next_corner(c)]};
      CHECK(ends == std::set<std::uint32_t>{other.vertex[o], other.vertex[next_corner(o)]});
      CHECK(face.length2(c) == doctest::Approx(other.length2(o)).epsilon(1e-9));
      if (cut.is_oriented) {
        CHECK(cut.ring(across) == h);
        CHECK(face.vertex[c] == other.vertex[next_corner(o)]);
      }
      // Rings are cycles.
      Halfedge back = across;
      int steps = 0;
      while (back != h && steps++ < 1000) back = cut.ring(back);
      REQUIRE(back == h);
    }
  }
  CHECK(boundary_after == boundary_before);
  std::size_t listed = 0;
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    for (const std::uint32_t corner : cut.corners(v)) {
      CHECK(cut.faces[face_of(corner)].vertex[corner_of(corner)] == v);
      ++listed;
    }
  }
  CHECK(listed == 3 * cut.faces.size());
}

}  // namespace

TEST_CASE("FlipsKeepASurfaceOriented") {
  const Surface surface(crooked_plane(8));
  const IntrinsicDelaunay delaunay = delaunay_of(surface);
  CHECK(delaunay.flips() > 0);
  CHECK(surface.adjacency().triangulation().is_oriented);
  CHECK(delaunay.triangulation().is_oriented);
  check_is_sound(surface, delaunay);

  TriangleSoup turned = crooked_plane(8);
  std::swap(turned.faces[50][0], turned.faces[50][1]);
  CHECK(!Surface(turned).adjacency().triangulation().is_oriented);
  TriangleSoup book = crooked_plane(8);
  book.positions.push_back({0, 0, 1});
  book.faces.push_back({book.faces[50][0], book.faces[50][1],
                        static_cast<std::uint32_t>(book.positions.size() - 1)});
  CHECK(!Surface(book).adjacency().triangulation().is_oriented);
}

TEST_CASE("EveryEdgeThatCanBeFlippedIsDelaunay") {
  for (const TriangleSoup& soup :
       {crooked_plane(1), crooked_plane(8), crooked_plane(100), shapes::terrain(30, 8, 2),
        shapes::shuffled(shapes::torus_knot(40, 6, 0.3), 4)}) {
    const Surface surface(soup);
    const IntrinsicDelaunay delaunay = delaunay_of(surface);
    check_is_sound(surface, delaunay);
    CHECK(delaunay.flips() > 0);
    CHECK(fixtures::edges_to_flip(delaunay.triangulation()) == 0);
  }
  for (std::uint32_t number = 0; number < 60; ++number) {
    CAPTURE(number);
    const Surface surface(RandomMesh(number).soup());
    const IntrinsicDelaunay delaunay = delaunay_of(surface);
    check_is_sound(surface, delaunay);
    CHECK(fixtures::edges_to_flip(delaunay.triangulation()) == 0);
  }
}

TEST_CASE("AwkwardMeshesStaySound") {
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    check_is_sound(surface, delaunay_of(surface));
  }
}

// On a flat surface edges are straight lines, and no circle through the corners of a
// face has a vertex in it.
TEST_CASE("OnAPlaneItIsTheDelaunayTriangulation") {
  for (const double stretch : {1.0, 8.0, 100.0}) {
    CAPTURE(stretch);
    const Surface surface(crooked_plane(stretch));
    const IntrinsicDelaunay delaunay = delaunay_of(surface);
    const auto positions = surface.mesh().positions();
    for (const FaceRecord& face : delaunay.triangulation().faces) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        const double straight =
            distance(positions[face.vertex[c]], positions[face.vertex[next_corner(c)]]);
        CHECK(std::sqrt(face.length2(c)) == doctest::Approx(straight).epsilon(1e-9));
      }
      const Vec3 a = positions[face.vertex[0]];
      const Vec3 b = positions[face.vertex[1]] - a;
      const Vec3 e = positions[face.vertex[2]] - a;
      const double twice = 2 * (b.x * e.y - b.y * e.x);
      const double b2 = dot(b, b);
      const double e2 = dot(e, e);
      const Vec3 centre{(e.y * b2 - b.y * e2) / twice, (b.x * e2 - e.x * b2) / twice, 0};
      for (const Vec3 p : positions) {
        CHECK(distance(p - a, centre) >= norm(centre) * (1 - 1e-9));
      }
    }
  }
}

// An edge is a way over the surface; where it is short for the curvature, the shortest.
TEST_CASE("NoEdgeIsShorterThanTheSurfaceAllows") {
  for (std::uint32_t number = 0; number < 12; ++number) {
    CAPTURE(number);
    const Surface surface(RandomMesh(number).soup());
    const IntrinsicDelaunay delaunay = delaunay_of(surface);
    const Triangulation cut = delaunay.triangulation();
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); v += 7) {
      const Field field =
          surface.field_by(Method::exact, {Source{point_at_vertex(surface.adjacency(), v), 0}});
      for (const std::uint32_t corner : cut.corners(v)) {
        const FaceRecord& face = cut.faces[face_of(corner)];
        const std::uint32_t c = corner_of(corner);
        CHECK(std::sqrt(face.length2(c)) >=
              field.distance[face.vertex[next_corner(c)]] * (1 - 1e-9));
      }
    }
  }
}

TEST_CASE("TheSameMeshIsCutTheSameWay") {
  const Surface one(shapes::terrain(20, 6, 9));
  const Surface other(shapes::terrain(20, 6, 9));
  const IntrinsicDelaunay first = delaunay_of(one);
  const IntrinsicDelaunay second = delaunay_of(other);
  const auto a = first.triangulation().faces;
  const auto b = second.triangulation().faces;
  REQUIRE(a.size() == b.size());
  for (std::size_t f = 0; f < a.size(); ++f) {
    REQUIRE(a[f].vertex == b[f].vertex);
    REQUIRE(a[f].ring == b[f].ring);
    REQUIRE(a[f].dot == b[f].dot);
    REQUIRE(a[f].area2 == b[f].area2);
  }
}

TEST_CASE("WhatHasNothingToImproveIsLeftAsItIs") {
  const Surface sphere(shapes::icosphere(3));
  CHECK(delaunay_of(sphere).flips() == 0);
  CHECK(sphere.adjacency().delaunay().faces.data() ==
        sphere.adjacency().triangulation().faces.data());
  const Surface hills(shapes::terrain(20, 6, 9));
  CHECK(hills.adjacency().delaunay().faces.data() !=
        hills.adjacency().triangulation().faces.data());
}

TEST_CASE("FlippingEndsWhenItIsCancelled") {
  const Surface surface(shapes::terrain(80, 20, 9));
  const Triangulation mesh = surface.adjacency().triangulation();
  for (int allowed = 0; allowed < 3; ++allowed) {
    int asked = 0;
    const auto result = IntrinsicDelaunay::build(mesh, surface.mesh().positions(),
                                                 Cancel([&] { return asked++ >= allowed; }));
    REQUIRE_FALSE(result.has_value());
    CHECK(result.error().code == ErrorCode::cancelled);
  }
}
