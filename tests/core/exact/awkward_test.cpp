// The exact field on surfaces that break window propagation elsewhere, with answers
// worked out by hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/field/window_table.h"
#include "core/mesh/shapes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

std::vector<double> exact_from(const Surface& surface, std::uint32_t source) {
  return surface.in_source_order(surface.field_by(Method::exact, {Source{surface.at(source), 0}}));
}

void check_close(double got, double wanted, double relative = 1e-12) {
  CAPTURE(got);
  CAPTURE(wanted);
  CHECK(std::abs(got - wanted) <= relative * wanted);
}

}  // namespace

TEST_CASE("ExactCrossesTheSpineOfABookToEveryPage") {
  TriangleSoup book;
  for (const Vec3 page : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 0, 1}, Vec3{0.6, 0, -0.8}}) {
    const auto first = static_cast<std::uint32_t>(book.positions.size());
    for (int j = 0; j < 6; ++j) {
      for (int i = 0; i < 6; ++i) {
        book.positions.push_back(double(i) * page + Vec3{0, double(j), 0});
      }
    }
    for (auto t : shapes::plane(6, 6).faces) {
      book.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  const Surface surface(book);
  CHECK(surface.adjacency().report().edges_non_manifold == 5);
  const auto d = exact_from(surface, 3 + 6 * 1);  // (3, 1) of the first page
  for (std::uint32_t page = 0; page < 4; ++page) {
    for (int j = 0; j < 6; ++j) {
      for (int i = 0; i < 6; ++i) {
        const double across = page == 0 ? i - 3 : i + 3;
        check_close(d[36 * page + 6 * j + i], std::hypot(across, j - 1));
      }
    }
  }
  const Field field = surface.field_by(Method::exact, {Source{surface.at(9), 0}});
  // Windows cross the spine into three pages, and none of those comes back into the first.
  int intervals = 0;
  for (std::uint32_t f = 0; f < surface.mesh().face_count(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      const Halfedge next = surface.adjacency().ring(h);
      if (surface.adjacency().ring(next) == h) continue;
      if (!field.windows->into(h).empty()) ++intervals;
    }
  }
  CHECK(intervals == 3 * 5);
}

TEST_CASE("ExactBendsAtABowtie") {
  // Two squares of four triangles each that share a corner.
  TriangleSoup soup = shapes::plane(3, 3);
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  for (const Vec3 p : shapes::plane(3, 3).positions) soup.positions.push_back(p + Vec3{2, 2, 0});
  for (auto t : shapes::plane(3, 3).faces) {
    soup.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  const Surface surface(soup);
  CHECK(surface.adjacency().report().vertices_pinched == 1);
  const auto d = exact_from(surface, 1);
  for (std::uint32_t i = 0; i < 9; ++i) {
    const Vec3 p = soup.positions[first + i];
    check_close(d[first + i], std::hypot(1, 2) + std::hypot(p.x - 2, p.y - 2));
  }
}

TEST_CASE("ExactIgnoresDuplicateAndFlippedFaces") {
  TriangleSoup soup = shapes::plane(8, 8);
  for (std::size_t f = 0; f < 98; f += 3) soup.faces.push_back(soup.faces[f]);
  for (std::size_t f = 0; f < 98; f += 7) {
    soup.faces.push_back({soup.faces[f][1], soup.faces[f][0], soup.faces[f][2]});
  }
  for (std::size_t f = 0; f < 98; f += 5) std::swap(soup.faces[f][1], soup.faces[f][2]);
  const Surface surface(soup);
  for (const std::uint32_t source : {0U, 27U}) {
    const auto d = exact_from(surface, source);
    for (std::size_t i = 0; i < d.size(); ++i) {
      check_close(d[i], distance(soup.positions[source], soup.positions[i]));
    }
  }
}

TEST_CASE("ExactPassesThroughFacesWithoutArea") {
  // Along some edges of the plane lies a vertex that only one side knows of; a face
  // without area joins the two.
  for (const double place : {0.25, 0.5, 0.875}) {
    TriangleSoup soup = shapes::plane(7, 7);
    const std::size_t count = soup.faces.size();
    for (std::size_t f = 0; f < count; f += 3) {
      const auto [a, b, c] = soup.faces[f];
      const auto v = static_cast<std::uint32_t>(soup.positions.size());
      soup.positions.push_back((1 - place) * soup.positions[a] + place * soup.positions[b]);
      soup.faces[f] = {a, v, c};
      soup.faces.push_back({v, b, c});
      soup.faces.push_back({a, b, v});
    }
    const Surface surface(soup);
    CHECK(surface.mesh().zero_area_face_count() > 20);
    for (const std::uint32_t source : {0U, 24U, 50U}) {
      const auto d = exact_from(surface, source);
      for (std::size_t i = 0; i < d.size(); ++i) {
        check_close(d[i], distance(soup.positions[source], soup.positions[i]));
      }
    }
  }
}

// Faces on one line, back to back: a way over them may lead back to where it was, and a path
// must not take the way round then.
TEST_CASE("ExactPathsLeaveFacesOnOneLineAgain") {
  const std::vector<std::vector<Triangle>> cases{{{2, 0, 1}, {3, 0, 1}, {0, 1, 2}, {2, 1, 3}},
                                                 {{1, 0, 2}, {1, 2, 0}, {3, 0, 1}},
                                                 {{1, 2, 0}, {0, 1, 2}, {3, 1, 2}}};
  for (const auto& faces : cases) {
    TriangleSoup soup;
    soup.positions = {{0, 2, 1}, {1, 4, 2}, {2, 6, 3}, {4.06, -0.06, 0}};
    soup.faces = faces;
    const Surface surface(soup);
    const Field field = surface.field_by(Method::exact, {Source{surface.at(3), 0}});
    for (const std::uint32_t v : {0U, 1U, 2U}) {
      const double d = field.distance[surface.vertex(v)];
      const auto path = *trace_path(surface.adjacency(), field, surface.at(v), Cancel());
      REQUIRE(path.has_value());
      check_close(path->length, d);
      if (v == 1) check_close(d, distance(soup.positions[1], soup.positions[3]));
    }
  }
}

// Light that is thrown to and fro between faces with the same corners, far thinner than
// rounding is small, would seem to gain each time, and never come to an end.
TEST_CASE("ExactComesToAnEndOnThinFacesSeveralTimesOver") {
  TriangleSoup thrice;
  thrice.positions = {{0.01, -0.01, 0}, {0.04, -0.04, 0}, {1000.03, -0.03, 2}, {4000, 1, 3}};
  thrice.faces = {{0, 1, 3}, {1, 0, 3}, {0, 2, 3}, {3, 2, 0}, {0, 3, 1}, {0, 2, 3}};
  TriangleSoup twice;
  twice.positions = {{1000.15, 6.85, 3}, {3000.15, 1.85, 0}, {2000.15, 0.85, 3},
                     {7000.09, 6.91, 3}, {7000.15, 6.85, 3}, {3000.12, -0.12, 0}};
  twice.faces = {{5, 3, 4}, {0, 1, 4}, {2, 4, 0}, {2, 1, 4},
                 {1, 4, 2}, {1, 4, 3}, {2, 4, 3}, {3, 2, 4}};
  for (const TriangleSoup& soup : {thrice, twice}) {
    const Surface surface(soup);
    for (std::uint32_t source = 0; source < soup.positions.size(); ++source) {
      const std::vector<Source> from{{surface.at(source), 0}};
      const auto d = surface.in_source_order(surface.field_by(Method::exact, from));
      const auto other = surface.in_source_order(surface.field_by(Method::chen_han, from));
      for (std::size_t v = 0; v < d.size(); ++v) CHECK(std::abs(d[v] - other[v]) <= 1e-7);
    }
  }
}

TEST_CASE("ExactPassesThroughCapsOfAnyThinness") {
  for (const double thin : {1e-2, 1e-5, 1e-8, 1e-11, 1e-14, 1e-17}) {
    CAPTURE(thin);
    const TriangleSoup soup = fixtures::plane_with_caps(thin);
    const Surface surface(soup);
    for (const std::uint32_t source : {0U, 14U, 40U}) {
      const auto d = exact_from(surface, source);
      for (std::size_t i = 0; i < d.size(); ++i) {
        check_close(d[i], distance(soup.positions[source], soup.positions[i]), 1e-11);
      }
    }
  }
}

TEST_CASE("ExactPassesThroughNeedlesOfAnyThinness") {
  for (const double thin : {1e-3, 1e-6, 1e-12, 1e-30}) {
    CAPTURE(thin);
    TriangleSoup soup = shapes::plane(9, 9);
    for (Vec3& p : soup.positions) p.x *= thin;
    const Surface surface(soup);
    const auto d = exact_from(surface, 40);
    for (std::size_t i = 0; i < d.size(); ++i) {
      check_close(d[i], distance(soup.positions[40], soup.positions[i]), 1e-11);
    }
  }
}

TEST_CASE("ExactOnASingleTriangle") {
  const Surface surface(TriangleSoup{{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}, {9, 9, 9}}, {{0, 1, 2}}});
  const auto d = exact_from(surface, 1);
  check_close(d[0], 3);
  check_close(d[2], 5);
  CHECK(d[3] == kUnreached);
  const auto from_side = surface.in_source_order(
      surface.field_by(Method::exact, {Source{surface.on(0, {0, 0.5, 0.5}), 0}}));
  for (int i = 0; i < 3; ++i) check_close(from_side[i], 2.5);
  const auto from_lone = exact_from(surface, 3);
  CHECK(from_lone[3] == 0);
  CHECK(from_lone[0] == kUnreached);
}

TEST_CASE("ExactLeavesOtherComponentsUnreached") {
  TriangleSoup soup = shapes::plane(4, 4);
  for (const Vec3 p : shapes::plane(4, 4).positions) soup.positions.push_back(p + Vec3{0, 0, 5});
  for (auto t : shapes::plane(4, 4).faces) soup.faces.push_back({t[0] + 16, t[1] + 16, t[2] + 16});
  const Surface surface(soup);
  const auto d = exact_from(surface, 5);
  for (int i = 0; i < 16; ++i) CHECK(d[16 + i] == kUnreached);
  const Field both =
      surface.field_by(Method::exact, {Source{surface.at(5), 0}, Source{surface.at(16), 0}});
  CHECK(both.reached == 32);
  CHECK(both.nearest_source[surface.vertex(31)] == 1);
}

// A strip twisted once.
TEST_CASE("ExactGoesRoundAMoebiusStrip") {
  const std::uint32_t n = 40;
  const TriangleSoup strip = fixtures::moebius_strip(n);
  const Surface surface(strip);
  // Both ways between two vertices are the same.
  for (const std::uint32_t other : {1U, n / 2, n, n + 1, 2 * n - 1}) {
    const double there = exact_from(surface, 0)[other];
    CHECK(there >= distance(strip.positions[0], strip.positions[other]) * (1 - 1e-12));
    check_close(exact_from(surface, other)[0], there);
  }
}

TEST_CASE("ExactScales") {
  const TriangleSoup unit = shapes::terrain(12, 3, 1);
  const auto expected = exact_from(Surface(unit), 0);
  for (const double scale : {0x1p-130, 0x1p130}) {
    TriangleSoup soup = unit;
    for (Vec3& p : soup.positions) p = scale * p;
    const auto d = exact_from(Surface(soup), 0);
    for (std::size_t i = 0; i < d.size(); ++i) check_close(d[i], scale * expected[i], 1e-12);
  }
}

// One square of a plane is a fan of a thousand times smaller squares: the widths of
// the queue's buckets fit neither.
TEST_CASE("ExactBearsEdgesOfVeryDifferentLengths") {
  TriangleSoup soup;
  double x = 1e-9;
  std::vector<std::uint32_t> low;
  for (int i = 0; i < 60; ++i, x *= 2) {
    for (const double y : {-x, x}) soup.positions.push_back({x, y, 0});
  }
  for (std::uint32_t i = 0; i + 3 < soup.positions.size(); i += 2) {
    soup.faces.push_back({i, i + 2, i + 1});
    soup.faces.push_back({i + 1, i + 2, i + 3});
  }
  const Surface surface(soup);
  for (const std::uint32_t source : {0U, 61U, 119U}) {
    const auto d = exact_from(surface, source);
    for (std::size_t i = 0; i < d.size(); ++i) {
      check_close(d[i], distance(soup.positions[source], soup.positions[i]));
    }
  }
}
