// Surfaces that public codes crash on, or leave unreached without a word. Each is
// small enough that the answer can be worked out by hand.
#include "tests/fixtures/awkward_meshes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "core/mesh/shapes.h"
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
  const Surface surface(fixtures::book_of_three_pages());
  CHECK(surface.adjacency().report().edges_non_manifold == 2);
  const auto d = checked_distances(surface, 2);  // the corner (2, 0) of the first page
  CHECK(d[9 + 2] == doctest::Approx(4));         // straight over the spine
  CHECK(d[18 + 2] == doctest::Approx(4));        // and up the third page
  CHECK(d[9 + 8] == doctest::Approx(std::hypot(4, 2)));
  CHECK(d[18 + 8] == doctest::Approx(std::hypot(4, 2)));
}

TEST_CASE("ABowtieVertexLetsDistancesThrough") {
  const Surface surface(fixtures::bowtie());
  CHECK(surface.adjacency().report().components == 1);
  const auto d = checked_distances(surface, 1);
  CHECK(d[0] == doctest::Approx(std::sqrt(2)));
  CHECK(d[3] == doctest::Approx(2 * std::sqrt(2)));
  CHECK(d[4] == doctest::Approx(2 * std::sqrt(2)));
}

TEST_CASE("DuplicateFacesChangeNoDistance") {
  const auto before = checked_distances(Surface(shapes::plane(8, 8)), 9);
  const auto after = checked_distances(Surface(fixtures::plane_with_duplicate_faces()), 9);
  for (std::size_t i = 0; i < before.size(); ++i) CHECK(after[i] == doctest::Approx(before[i]));
}

TEST_CASE("FacesWithoutAreaJoinTheirNeighbours") {
  const Surface surface(fixtures::seam_without_area());
  const auto d = checked_distances(surface, 0);
  CHECK(d[5] == doctest::Approx(2));
  CHECK(d[6] == doctest::Approx(std::hypot(2, 1)).epsilon(0.02));
  CHECK(d[4] == doctest::Approx(std::hypot(1, 0.5)).epsilon(0.02));
}

TEST_CASE("EdgesWithoutLengthAreWelded") {
  const auto before = checked_distances(Surface(shapes::plane(6, 6)), 0);
  const Surface surface(fixtures::plane_with_edge_without_length());
  CHECK(surface.mesh().dropped_face_count() == 1);
  const auto after = checked_distances(surface, 0);
  for (std::size_t i = 0; i < before.size(); ++i) CHECK(after[i] == doctest::Approx(before[i]));
  CHECK(after[36] == after[14]);
}

TEST_CASE("OneFlippedFaceChangesNoDistance") {
  const auto before = checked_distances(Surface(shapes::plane(8, 8)), 0);
  const auto after = checked_distances(Surface(fixtures::plane_with_flipped_faces()), 0);
  for (std::size_t i = 0; i < before.size(); ++i) CHECK(after[i] == doctest::Approx(before[i]));
}

TEST_CASE("ASingleTriangle") {
  const Surface surface(fixtures::single_triangle());
  const auto d = checked_distances(surface, 1);
  CHECK(d[0] == doctest::Approx(3));
  CHECK(d[2] == doctest::Approx(5));
}

TEST_CASE("AMoebiusStripIsWalkedAllTheWayRound") {
  const std::uint32_t n = 40;
  const TriangleSoup strip = fixtures::moebius_strip(n);
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
    const Surface needle(fixtures::needles(thin));
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
