#include "core/surface/adjacency.h"

#include <doctest/doctest.h>

#include <cmath>
#include <set>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

std::size_t ring_size(const Adjacency& adjacency, Halfedge start) {
  std::size_t size = 1;
  for (Halfedge h = adjacency.ring(start); h != start; h = adjacency.ring(h)) ++size;
  return size;
}

}  // namespace

TEST_CASE("RingsJoinEveryHalfedgeOfAnEdge") {
  const Surface surface(shapes::shuffled(shapes::terrain(12, 2, 3), 1));
  const Adjacency& adjacency = surface.adjacency();
  for (std::uint32_t f = 0; f < surface.mesh().face_count(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      const auto ends = [&](Halfedge x) {
        const FaceRecord& face = adjacency.face(face_of(x));
        return std::set{face.vertex[corner_of(x)], face.vertex[next_corner(corner_of(x))]};
      };
      CHECK(ring_size(adjacency, h) <= 2);
      CHECK(ends(adjacency.ring(h)) == ends(h));
    }
  }
}

TEST_CASE("ReportsTheTopologyOfClosedAndOpenSurfaces") {
  const auto report = [](const TriangleSoup& soup) { return Surface(soup).adjacency().report(); };

  const TopologyReport sphere = report(shapes::icosphere(2));
  CHECK(sphere.edges == 480);
  CHECK(sphere.boundary_loops == 0);
  CHECK(sphere.components == 1);
  CHECK(sphere.edges_non_manifold == 0);

  const TopologyReport plane = report(shapes::plane(5, 4));
  CHECK(plane.boundary_loops == 1);
  CHECK(plane.edges_boundary == 14);
  CHECK(plane.mean_edge == doctest::Approx((4 * 4 + 3 * 5 + 12 * std::sqrt(2)) / 43));

  const std::vector<shapes::Hole> holes{{2, 2, 2}, {6, 6, 2}};
  const TopologyReport holed = report(shapes::plane_with_holes(12, 12, holes));
  CHECK(holed.boundary_loops == 3);
  CHECK(holed.vertices_isolated == 2);  // the one vertex inside each hole
}

TEST_CASE("HolesThatTouchInOneVertexShareALoop") {
  // The surface is pinched there: its inner boundary runs round both holes.
  const std::vector<shapes::Hole> holes{{1, 1, 1}, {2, 2, 1}};
  const Surface surface(shapes::plane_with_holes(5, 5, holes));
  CHECK(surface.adjacency().report().boundary_loops == 2);
  CHECK(surface.adjacency().report().vertices_pinched == 1);
  CHECK(surface.adjacency().is_pinched(surface.vertex(12)));
}

TEST_CASE("PinchedIsWhereFacesShareNoEdge") {
  CHECK(Surface(shapes::icosphere(2)).adjacency().report().vertices_pinched == 0);
  CHECK(Surface(shapes::plane(4, 4)).adjacency().report().vertices_pinched == 0);
  // A book's spine joins its pages through edges.
  const TriangleSoup book{{{0, 0, 0}, {0, 1, 0}, {1, 0.5, 0}, {-1, 0.5, 0.5}, {-1, 0.5, -0.5}},
                          {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  CHECK(Surface(book).adjacency().report().vertices_pinched == 0);
  // Two books of three pages that touch in a vertex.
  TriangleSoup two = book;
  for (const Vec3 p : {Vec3{0, -1, 0}, Vec3{3, -1, 0}, Vec3{3, -1, 3}, Vec3{-3, -1, 3}}) {
    two.positions.push_back(p);
  }
  two.faces.insert(two.faces.end(), {{0, 5, 6}, {0, 5, 7}, {0, 5, 8}});
  const Surface surface(two);
  CHECK(surface.adjacency().report().vertices_pinched == 1);
  CHECK(surface.adjacency().is_pinched(surface.vertex(0)));
  CHECK(surface.adjacency().report().components == 1);
}

TEST_CASE("AFlippedFaceChangesNothing") {
  TriangleSoup soup = shapes::plane(4, 4);
  const TopologyReport before = Surface(soup).adjacency().report();
  std::swap(soup.faces[3][0], soup.faces[3][1]);
  const TopologyReport after = Surface(soup).adjacency().report();
  CHECK(after.boundary_loops == before.boundary_loops);
  CHECK(after.edges_boundary == before.edges_boundary);
  CHECK(after.edges_non_manifold == 0);
}

TEST_CASE("ThreePagesOnOneEdgeFormOneRing") {
  const TriangleSoup book{{{0, 0, 0}, {0, 1, 0}, {1, 0.5, 0}, {-1, 0.5, 0.5}, {-1, 0.5, -0.5}},
                          {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  const Surface surface(book);
  const Adjacency& adjacency = surface.adjacency();
  CHECK(adjacency.report().edges_non_manifold == 1);
  const Halfedge spine = adjacency.find_edge(surface.vertex(0), surface.vertex(1));
  REQUIRE(spine != kNone);
  CHECK(ring_size(adjacency, spine) == 3);
  CHECK(adjacency.find_edge(surface.vertex(2), surface.vertex(3)) == kNone);
}

TEST_CASE("CountsDuplicateFaces") {
  TriangleSoup soup = shapes::plane(3, 3);
  soup.faces.push_back({soup.faces[0][2], soup.faces[0][1], soup.faces[0][0]});
  soup.faces.push_back(soup.faces[0]);
  CHECK(Surface(soup).adjacency().report().faces_duplicate == 2);
}

TEST_CASE("AMoebiusStripHasOneBoundary") {
  const std::uint32_t n = 12;
  const TriangleSoup strip = fixtures::moebius_strip(n);
  const TopologyReport report = Surface(strip).adjacency().report();
  CHECK(report.boundary_loops == 1);
  CHECK(report.edges_non_manifold == 0);
  CHECK(report.edges_boundary == 2 * n);
}

TEST_CASE("GeometryOfAFaceIsThatOfItsCorners") {
  const Surface surface(TriangleSoup{{{0, 0, 0}, {4, 0, 0}, {1, 3, 0}}, {{0, 1, 2}}});
  const FaceRecord& face = surface.adjacency().face(0);
  for (std::uint32_t c = 0; c < 3; ++c) {
    const Vec3 p = surface.mesh().positions()[face.vertex[c]];
    const Vec3 q = surface.mesh().positions()[face.vertex[next_corner(c)]];
    const Vec3 w = surface.mesh().positions()[face.vertex[previous_corner(c)]];
    const UnfoldedApex apex = face.apex_over(c);
    CHECK(face.length2(c) == doctest::Approx(dot(q - p, q - p)));
    CHECK(apex.from_p == doctest::Approx(dot(w - p, q - p)));
    CHECK(apex.from_q == doctest::Approx(dot(w - q, p - q)));
    CHECK(apex.height == doctest::Approx(12));
    CHECK(apex.to_p2 == doctest::Approx(dot(w - p, w - p)));
    CHECK(apex.to_q2 == doctest::Approx(dot(w - q, w - q)));
  }
}
