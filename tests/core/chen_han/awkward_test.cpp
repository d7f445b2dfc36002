// Chen and Han's method on the surfaces that public codes crash on, hang on or get
// wrong: non-manifold edges, pinched vertices, faces twice over or without area.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/wavefront/edge_dijkstra.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

std::vector<double> distances(const Surface& surface, std::uint32_t from) {
  return surface.in_source_order(surface.field_by(Method::chen_han, {Source{surface.at(from), 0}}));
}

void check_near(double value, double expected, double part = 1e-12) {
  CHECK(std::abs(value - expected) <= part * std::abs(expected));
}

// Ends, reaches what is joined, and is nowhere longer than the way along edges.
void check_ends(const TriangleSoup& soup) {
  const Surface surface(soup);
  const std::vector<Source> sources{{surface.at(0), 0}};
  const Field field = surface.field_by(Method::chen_han, sources);
  const Field edges = surface.field_by(Method::dijkstra, sources);
  CHECK(field.reached == edges.reached);
  for (std::size_t v = 0; v < field.distance.size(); ++v) {
    if (edges.distance[v] == kUnreached) continue;
    CHECK(field.distance[v] <= edges.distance[v] * (1 + 1e-12));
  }
}

}  // namespace

TEST_CASE("ChenHanPassesAllPagesOfABook") {
  const std::uint32_t n = 6;
  TriangleSoup book;
  const std::vector<Vec3> out{{1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0.6, 0, -0.8}};
  for (const Vec3 page : out) {
    const auto first = static_cast<std::uint32_t>(book.positions.size());
    for (std::uint32_t v = 0; v < n * n; ++v) {
      book.positions.push_back(double(v % n) * page + Vec3{0, double(v / n), 0});
    }
    for (const Triangle& t : shapes::plane(n, n).faces) {
      book.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  const Surface surface(book);
  CHECK(surface.adjacency().report().edges_non_manifold == n - 1);
  const auto d = distances(surface, 4 + n);  // four columns out, in row one
  for (std::uint32_t v = 0; v < 4 * n * n; ++v) {
    const double column = v % n;
    const double dx = v < n * n ? column - 4 : column + 4;
    check_near(d[v], std::hypot(dx, double(v / n % n) - 1));
  }
}

TEST_CASE("ChenHanPassesABowtie") {
  const Surface surface(TriangleSoup{{{0, 0, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, 1, 0}, {1, -1, 0}},
                                     {{0, 1, 2}, {0, 3, 4}}});
  const auto d = distances(surface, 1);
  check_near(d[0], std::sqrt(2.0));
  check_near(d[3], 2 * std::sqrt(2.0));
  check_near(d[4], 2 * std::sqrt(2.0));
}

TEST_CASE("ChenHanDuplicateAndFlippedFacesChangeNothing") {
  TriangleSoup soup = shapes::terrain(9, 3, 2);
  const auto before = distances(Surface(soup), 9);
  const std::size_t count = soup.faces.size();
  for (std::size_t f = 0; f < count; ++f) {
    const Triangle t = soup.faces[f];
    soup.faces.push_back({t[1], t[0], t[2]});
    if (f % 3 == 0) soup.faces.push_back({t[1], t[2], t[0]});
    if (f % 5 == 0) std::swap(soup.faces[f][0], soup.faces[f][1]);
  }
  const auto after = distances(Surface(soup), 9);
  for (std::size_t v = 0; v < before.size(); ++v) check_near(after[v], before[v]);
}

TEST_CASE("ChenHanPassesFacesWithoutArea") {
  // Two squares whose seam has one edge on the left, two on the right, and a face
  // without area between them.
  const Surface surface(
      TriangleSoup{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0.5, 0}, {2, 0, 0}, {2, 1, 0}},
                   {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}, {1, 5, 4}, {4, 5, 6}, {4, 6, 2}}});
  CHECK(surface.mesh().zero_area_face_count() == 1);
  for (std::uint32_t from = 0; from < 7; ++from) {
    const auto d = distances(surface, from);
    for (std::uint32_t v = 0; v < 7; ++v) {
      const auto p = surface.mesh().positions();
      check_near(d[v], distance(p[surface.vertex(from)], p[surface.vertex(v)]), 1e-9);
    }
  }
}

TEST_CASE("ChenHanOnASingleTriangle") {
  const auto d =
      distances(Surface(TriangleSoup{{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, {{0, 1, 2}}}), 1);
  check_near(d[0], 3);
  check_near(d[2], 5);
}

TEST_CASE("ChenHanLeavesOtherComponentsUnreached") {
  TriangleSoup soup = shapes::plane(4, 4);
  for (const Vec3 p : {Vec3{9, 0, 0}, Vec3{9, 1, 0}, Vec3{8, 0, 0}, Vec3{7, 7, 7}}) {
    soup.positions.push_back(p);
  }
  soup.faces.push_back({16, 17, 18});
  const auto d = distances(Surface(soup), 0);
  check_near(d[15], 3 * std::sqrt(2.0));
  for (std::uint32_t v = 16; v < 20; ++v) CHECK(d[v] == kUnreached);
  const auto alone = distances(Surface(soup), 19);  // in no face
  CHECK(alone[19] == 0);
  CHECK(alone[0] == kUnreached);
}

TEST_CASE("ChenHanScalesToTheLastBit") {
  const TriangleSoup unit = shapes::terrain(12, 3, 1);
  const auto expected = distances(Surface(unit), 0);
  for (const double scale : {0x1p-130, 0x1p130}) {
    TriangleSoup soup = unit;
    for (Vec3& p : soup.positions) p = scale * p;
    const auto d = distances(Surface(soup), 0);
    for (std::size_t v = 0; v < d.size(); ++v) CHECK(d[v] == scale * expected[v]);
  }
}

TEST_CASE("ChenHanEndsOnNeedles") {
  for (const double thin : {1e-3, 1e-6, 1e-12, 1e-30}) {
    CAPTURE(thin);
    check_ends({{{0, 0, 0}, {1, thin, 0}, {2, 0, thin}, {3, 0, 0}},
                {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}});
    const Surface needle(
        TriangleSoup{{{0, 0, 0}, {1, 0, 0}, {1, thin, 0}, {2, 0, 0}, {0.5, thin / 2, 0}},
                     {{0, 1, 2}, {1, 3, 2}, {0, 2, 4}}});
    check_near(distances(needle, 0)[3], 2, 1e-9);
  }
}

TEST_CASE("ChenHanPassesThroughCapsOfAnyThinness") {
  for (const double thin : {1e-2, 1e-5, 1e-8, 1e-11, 1e-14, 1e-17}) {
    CAPTURE(thin);
    const TriangleSoup soup = fixtures::plane_with_caps(thin);
    const Surface surface(soup);
    for (const std::uint32_t source : {0U, 14U, 40U}) {
      const auto d = distances(surface, source);
      for (std::size_t i = 0; i < d.size(); ++i) {
        check_near(d[i], distance(soup.positions[source], soup.positions[i]), 1e-11);
      }
    }
  }
}

TEST_CASE("ChenHanEndsWhereEveryFaceMeetsEveryOther") {
  // All triangles of nine points: seven faces on each edge.
  TriangleSoup soup = shapes::icosphere(0);
  soup.positions.resize(9);
  soup.faces.clear();
  for (std::uint32_t i = 0; i < 9; ++i) {
    for (std::uint32_t j = i + 1; j < 9; ++j) {
      for (std::uint32_t k = j + 1; k < 9; ++k) soup.faces.push_back({i, j, k});
    }
  }
  check_ends(soup);
}

TEST_CASE("ChenHanEndsOnSheetsGluedAtAllVertices") {
  // Two sheets with the same vertices and sides, cut by different diagonals: every
  // ray goes on through both of them.
  TriangleSoup soup = shapes::plane(12, 12, shapes::Diagonal::rising);
  const TriangleSoup other = shapes::plane(12, 12, shapes::Diagonal::falling);
  soup.faces.insert(soup.faces.end(), other.faces.begin(), other.faces.end());
  const auto d = distances(Surface(soup), 0);
  for (std::uint32_t v = 0; v < 144; ++v) check_near(d[v], std::hypot(v % 12, v / 12));
}

TEST_CASE("ChenHanGoesRoundAMoebiusStrip") {
  const std::uint32_t n = 40;
  const TriangleSoup strip = fixtures::moebius_strip(n);
  check_ends(strip);
  const auto d = distances(Surface(strip), 0);
  CHECK(d[2 * n - 2] < d[n]);
  check_near(d[1], 0.6);
}
