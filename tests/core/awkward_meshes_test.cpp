// Surfaces that public codes crash on, or leave unreached without a word. Each is
// small enough that the answer can be worked out by hand.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "core/shapes.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

// Every vertex of every face is reached, finitely, with a path that is a path.
std::vector<double> checked_distances(const Surface& surface, std::uint32_t source) {
  const Field field = surface.field_from(source);
  const auto distances = surface.in_source_order(field);
  for (std::uint32_t i = 0; i < distances.size(); ++i) {
    if (surface.adjacency().corners(surface.vertex(i)).empty()) continue;
    CHECK(std::isfinite(distances[i]));
    const auto path = surface.path(field, surface.at(i));
    REQUIRE(path);
    fixtures::check_is_a_path(surface.adjacency(), *path, 10);
  }
  return distances;
}

}  // namespace

TEST_CASE("ABookOfThreePages") {
  // Pages of 2 x 2 squares on the spine x = 0, z = 0.
  TriangleSoup book;
  const std::vector<Vec3> out{{1, 0, 0}, {-1, 0, 0}, {0, 0, 1}};
  for (const Vec3 page : out) {
    const auto first = static_cast<std::uint32_t>(book.positions.size());
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i)
        book.positions.push_back(double(i) * page + Vec3{0, double(j), 0});
    }
    for (auto t : shapes::plane(3, 3).faces) {
      book.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  const Surface surface(book);
  CHECK(surface.adjacency().report().edges_non_manifold == 2);
  const auto d = checked_distances(surface, 2);  // the corner (2, 0) of the first page
  CHECK(d[9 + 2] == doctest::Approx(4));         // straight over the spine
  CHECK(d[18 + 2] == doctest::Approx(4));        // and up the third page
  CHECK(d[9 + 8] == doctest::Approx(std::hypot(4, 2)));
  CHECK(d[18 + 8] == doctest::Approx(std::hypot(4, 2)));
}

TEST_CASE("ABowtieVertexLetsDistancesThrough") {
  const Surface surface(TriangleSoup{{{0, 0, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, 1, 0}, {1, -1, 0}},
                                     {{0, 1, 2}, {0, 3, 4}}});
  CHECK(surface.adjacency().report().components == 1);
  const auto d = checked_distances(surface, 1);
  CHECK(d[0] == doctest::Approx(std::sqrt(2)));
  CHECK(d[3] == doctest::Approx(2 * std::sqrt(2)));
  CHECK(d[4] == doctest::Approx(2 * std::sqrt(2)));
}

TEST_CASE("DuplicateFacesChangeNoDistance") {
  TriangleSoup soup = shapes::plane(8, 8);
  const auto before = checked_distances(Surface(soup), 9);
  for (std::size_t f = 0; f < 98; f += 3) soup.faces.push_back(soup.faces[f]);
  for (std::size_t f = 0; f < 98; f += 7) {
    soup.faces.push_back({soup.faces[f][1], soup.faces[f][0], soup.faces[f][2]});
  }
  const auto after = checked_distances(Surface(soup), 9);
  for (std::size_t i = 0; i < before.size(); ++i) CHECK(after[i] == doctest::Approx(before[i]));
}

TEST_CASE("FacesWithoutAreaJoinTheirNeighbours") {
  // Two squares; along the seam the left one has one edge and the right one two,
  // with a face without area between them.
  const Surface surface(
      TriangleSoup{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0.5, 0}, {2, 0, 0}, {2, 1, 0}},
                   {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}, {1, 5, 4}, {4, 5, 6}, {4, 6, 2}}});
  const auto d = checked_distances(surface, 0);
  CHECK(d[5] == doctest::Approx(2));
  CHECK(d[6] == doctest::Approx(std::hypot(2, 1)).epsilon(0.02));
  CHECK(d[4] == doctest::Approx(std::hypot(1, 0.5)).epsilon(0.02));
}

TEST_CASE("EdgesWithoutLengthAreWelded") {
  TriangleSoup soup = shapes::plane(6, 6);
  const auto before = checked_distances(Surface(soup), 0);
  // Vertex 14 twice, and a sliver of no size between the two.
  soup.positions.push_back(soup.positions[14]);
  for (std::size_t f = 0; f < soup.faces.size(); f += 2) {
    for (std::uint32_t& v : soup.faces[f]) {
      if (v == 14) v = 36;
    }
  }
  soup.faces.push_back({14, 36, 15});
  const Surface surface(soup);
  CHECK(surface.mesh().dropped_face_count() == 1);
  const auto after = checked_distances(surface, 0);
  for (std::size_t i = 0; i < before.size(); ++i) CHECK(after[i] == doctest::Approx(before[i]));
  CHECK(after[36] == after[14]);
}

TEST_CASE("OneFlippedFaceChangesNoDistance") {
  TriangleSoup soup = shapes::plane(8, 8);
  const auto before = checked_distances(Surface(soup), 0);
  for (std::size_t f = 0; f < soup.faces.size(); f += 5)
    std::swap(soup.faces[f][1], soup.faces[f][2]);
  const auto after = checked_distances(Surface(soup), 0);
  for (std::size_t i = 0; i < before.size(); ++i) CHECK(after[i] == doctest::Approx(before[i]));
}

TEST_CASE("ASingleTriangle") {
  const Surface surface(TriangleSoup{{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, {{0, 1, 2}}});
  const auto d = checked_distances(surface, 1);
  CHECK(d[0] == doctest::Approx(3));
  CHECK(d[2] == doctest::Approx(5));
}

TEST_CASE("AMoebiusStripIsWalkedAllTheWayRound") {
  const std::uint32_t n = 40;
  TriangleSoup strip;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double u = 2 * 3.141592653589793 * i / n;
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
  const auto d = checked_distances(Surface(strip), 0);
  // Halfway round: longer than the straight line through space, no longer than
  // along the edge of the strip.
  double along_edge = 0;
  for (std::uint32_t i = 0; i < n; i += 2) {
    along_edge += distance(strip.positions[i], strip.positions[i + 2]);
  }
  CHECK(d[n] > distance(strip.positions[0], strip.positions[n]));
  CHECK(d[n] <= along_edge * (1 + 1e-12));
  // Once round the edge leads to the other side of where it began.
  CHECK(d[2 * n - 2] < d[n]);
  CHECK(d[1] == doctest::Approx(0.6));
}

TEST_CASE("NeedlesAndCapsStayFinite") {
  for (const double thin : {1e-3, 1e-6, 1e-12, 1e-30}) {
    const Surface needle(
        TriangleSoup{{{0, 0, 0}, {1, 0, 0}, {1, thin, 0}, {2, 0, 0}, {0.5, thin / 2, 0}},
                     {{0, 1, 2}, {1, 3, 2}, {0, 2, 4}}});
    const auto d = checked_distances(needle, 0);
    CHECK(d[3] == doctest::Approx(2));
  }
}

TEST_CASE("HugeAndTinyMeshesScale") {
  const TriangleSoup unit = shapes::terrain(12, 3, 1);
  const auto expected = checked_distances(Surface(unit), 0);
  for (const double scale : {0x1p-130, 0x1p130}) {
    TriangleSoup soup = unit;
    for (Vec3& p : soup.positions) p = scale * p;
    const Surface surface(soup);
    const auto d = surface.in_source_order(surface.field_from(0));
    for (std::size_t i = 0; i < d.size(); ++i) {
      CHECK(d[i] == doctest::Approx(scale * expected[i]).epsilon(1e-9));
    }
  }
}
