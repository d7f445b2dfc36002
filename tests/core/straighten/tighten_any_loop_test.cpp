// Loops on surfaces drawn at random and on awkward ones, against the definition of a locally
// shortest path.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/solve/distance_at_point.h"
#include "core/straighten/tighten_loop.h"
#include "tests/core/straighten/loops.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/shortened.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/tube.h"

using namespace geodesic;
using namespace geodesic::loops;
using fixtures::Surface;

// Parts of the loop against exact distances: nowhere is there a short cut.
TEST_CASE("NoShortCutNearALoop") {
  std::mt19937 random(fixtures::test_seed() + 7);
  int loops = 0;
  for (int round = 0; round < 12; ++round) {
    TriangleSoup soup = shapes::torus_knot(24 + random() % 20, 6 + random() % 5, 0.3);
    for (Vec3& p : soup.positions) p = p + 0.05 * any_direction(random);
    const Surface surface(soup);
    const auto v = static_cast<std::uint32_t>(random() % soup.positions.size());
    const auto start = section_of(surface, surface.at(v), any_direction(random));
    if (!start) continue;
    const auto result = tighten_loop(surface.adjacency(), *start, Cancel());
    if (!result) {
      CHECK(result.error().code == ErrorCode::no_loop);
      continue;
    }
    check_tight(surface, *start, *result);
    check_is_geodesic(surface, result->path);
    ++loops;
    const auto& points = result->path.points;
    for (int pair = 0; pair < 3; ++pair) {
      const std::size_t i = random() % (points.size() - 1);
      const SurfacePoint from = points[i].point;
      const Field field = surface.field_by(Method::exact, {Source{from, 0}});
      double part = 0;
      for (std::size_t k = i; k + 1 < points.size() && part < 0.25 * result->path.length; ++k) {
        part += distance(points[k].position, points[k + 1].position);
        if (part > 0.2) break;  // near: the tube is 0.3 thick
        const auto path = surface.path(field, points[k + 1].point);
        REQUIRE(path);
        CHECK(part <= path->length * (1 + 1e-9));
      }
    }
  }
  CHECK(loops > 0);
}

TEST_CASE("LoopsOnAnySurfaceAreClosedAndNoLongerThanTheyWere") {
  std::mt19937 random(fixtures::test_seed() + 8);
  int loops = 0;
  for (int round = 0; round < 120; ++round) {
    fixtures::RandomMesh mesh(random());
    const Surface surface(mesh.soup());
    std::optional<Path> start;
    if (round % 2 == 0) {
      start = round_by(surface, {mesh.vertex(), mesh.vertex(), mesh.vertex(), mesh.vertex()});
    } else {
      start = section_of(surface, surface.at(mesh.vertex()), any_direction(random));
    }
    if (!start) continue;
    const auto loop = tighten_loop(surface.adjacency(), *start, Cancel());
    if (!loop) {
      CHECK(loop.error().code == ErrorCode::no_loop);
      continue;
    }
    check_tight(surface, *start, *loop);
    const auto straightness = straightness_of_loop(surface.adjacency(), loop->path, Cancel());
    REQUIRE(straightness);
    if (straightness->is_known) CHECK(straightness->lack <= 1e-6);
    ++loops;
    // Once more, it stays as long as it is.
    const auto again = tighten_loop(surface.adjacency(), loop->path, Cancel());
    REQUIRE(again);
    CHECK(again->path.length >= loop->path.length * (1 - 1e-6));
  }
  CHECK(loops > 0);
}

TEST_CASE("LoopsOnAwkwardMeshesComeToAnEnd") {
  std::mt19937 random(fixtures::test_seed() + 9);
  for (const auto& awkward : fixtures::awkward_meshes()) {
    CAPTURE(awkward.name);
    const Surface surface(awkward.soup);
    for (int round = 0; round < 6; ++round) {
      std::vector<std::uint32_t> vertices{awkward.source};
      for (int i = 0; i < 3; ++i) {
        vertices.push_back(awkward.soup.faces[random() % awkward.soup.faces.size()][i]);
      }
      for (const auto& start :
           {round_by(surface, vertices),
            section_of(surface, surface.at(vertices[1]), any_direction(random))}) {
        if (!start) continue;
        const auto loop = tighten_loop(surface.adjacency(), *start, Cancel());
        if (loop) {
          check_tight(surface, *start, *loop);
        } else {
          CHECK(loop.error().code == ErrorCode::no_loop);
        }
      }
    }
  }
}

TEST_CASE("RoundAMoebiusStripALoopComesBackOnTheOtherSide") {
  const Surface surface(fixtures::moebius_strip(40));
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t i = 0; i < surface.mesh().source_vertex_count(); i += 2) vertices.push_back(i);
  const auto start = round_by(surface, vertices);
  REQUIRE(start);
  const TightLoop loop = tight(surface, *start);
  check_is_geodesic(surface, loop.path);
  CHECK(loop.path.length > 0.5 * start->length);
}

TEST_CASE("ATighteningIsCancelled") {
  const Surface surface(fixtures::tube(2000, 3, 6));
  const auto start = section_of(surface, surface.at(6500), {0.3, 0, 1});
  REQUIRE(start);
  int asked = 0;
  const Cancel counting([&] { return ++asked, false; });
  REQUIRE(tighten_loop(surface.adjacency(), *start, counting));
  REQUIRE(asked > 2);
  for (const int after : {0, 1, asked - 1}) {
    int left = after;
    const Cancel cancel([&] { return left-- <= 0; });
    const auto loop = tighten_loop(surface.adjacency(), *start, cancel);
    REQUIRE_FALSE(loop);
    CHECK(loop.error().code == ErrorCode::cancelled);
  }
}
