#include "core/surface/line_gaps.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "core/base/memory_budget.h"
#include "core/refine/cut_along.h"
#include "core/refine/faces_inside.h"
#include "tests/core/refine/cut_surface.h"
#include "tests/core/refine/lines_on_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/uneven_planes.h"

using namespace geodesic;
using fixtures::at_position;
using fixtures::Cut;
using fixtures::plane_of_eighths;
using fixtures::put_flat_faces_in;
using fixtures::RandomMesh;
using fixtures::straight;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

// A point of the plane that both meshes of it have, inside a face or at a vertex.
struct Twice {
  SurfacePoint plain;
  SurfacePoint flat;
};

Twice point_of_both(RandomMesh& random, const Surface& plain, const Surface& flat) {
  if (random.unit() < 0.3) {
    const std::uint32_t vertex = random.below(plain.mesh().source_vertex_count());
    return {plain.at(vertex), flat.at(vertex)};
  }
  const SurfacePoint point = fixtures::random_point(random, plain);
  return {point, at_position(flat, position_of(plain.mesh(), point))};
}

}  // namespace

TEST_CASE("LinesThroughFacesWithoutWidthAreThoseOfTheSameSurfaceWithoutThem") {
  std::size_t left_out = 0;
  for (std::uint32_t round = 0; round < 40; ++round) {
    CAPTURE(round);
    RandomMesh random(test_seed() + round);
    const TriangleSoup soup = plane_of_eighths(random, 4 + random.below(4));
    TriangleSoup split = soup;
    for (std::uint32_t i = 0; i <= random.below(3); ++i) put_flat_faces_in(random, split);
    const Surface plain(soup);
    const Surface flat(split);
    const Twice a = point_of_both(random, plain, flat);
    const Twice b = point_of_both(random, plain, flat);
    if (distance(position_of(plain.mesh(), a.plain), position_of(plain.mesh(), b.plain)) < 0.1) {
      continue;
    }
    const SurfacePolyline line = straight(flat, a.flat, b.flat);
    const Cancel never;
    Poll poll(never);
    const SurfacePolyline whole = close_gaps(flat.adjacency(), line, Gaps::at_vertices, poll);
    left_out += whole.size() - line.size();
    double longer = 0;
    for (std::size_t i = 1; i < whole.size(); ++i) {
      CHECK(face_in_common(flat.adjacency(), whole[i - 1], whole[i], poll) != kNone);
      longer +=
          distance(position_of(flat.mesh(), whole[i - 1]), position_of(flat.mesh(), whole[i]));
    }
    CHECK(longer == doctest::Approx(distance(position_of(flat.mesh(), a.flat),
                                             position_of(flat.mesh(), b.flat))));
    // A wall stops there what it stops on the plane.
    const Cut plain_cut(plain, {straight(plain, a.plain, b.plain)});
    const Cut flat_cut(flat, {line});
    const SurfacePoint from = fixtures::random_point(random, plain);
    const auto bary_of = [](const SurfacePoint& point) { return Weights(point.bary); };
    const Field wanted =
        plain_cut.field(plain_cut.on(plain.mesh().source_of_face(from.face), bary_of(from)));
    const SurfacePoint there = at_position(flat, position_of(plain.mesh(), from));
    const Field found =
        flat_cut.field(flat_cut.on(flat.mesh().source_of_face(there.face), bary_of(there)));
    for (std::uint32_t s = 0; s < soup.positions.size(); ++s) {
      CAPTURE(s);
      // On the wall itself it depends on the side that is meant.
      const auto least = [s](const Cut& cut, const Field& field) {
        double distance = kUnreached;
        for (std::uint32_t v = 0; v < cut.cut.mesh.vertex_count(); ++v) {
          if (cut.cut.mesh.source_of_vertex(v) == s) {
            distance = std::min(distance, field.distance[v]);
          }
        }
        return distance;
      };
      const double expected = least(plain_cut, wanted);
      if (expected == kUnreached) {
        CHECK(least(flat_cut, found) == kUnreached);
      } else {
        CHECK(least(flat_cut, found) == doctest::Approx(expected).epsilon(1e-9));
      }
    }
  }
  CHECK(left_out > 20);
}

TEST_CASE("LinesOfWhichNothingIsLeftOutStayAsTheyAre") {
  for (std::uint32_t round = 0; round < 60; ++round) {
    CAPTURE(round);
    RandomMesh random(test_seed() + round);
    const Surface surface(random.soup());
    const SurfacePolyline line = fixtures::random_line(random, surface.adjacency(), 12);
    const Cancel never;
    Poll poll(never);
    const SurfacePolyline whole = close_gaps(surface.adjacency(), line, Gaps::at_vertices, poll);
    REQUIRE(whole.size() == line.size());
    for (std::size_t i = 0; i < line.size(); ++i) {
      CHECK(whole[i].face == line[i].face);
      CHECK(whole[i].vertex == line[i].vertex);
      CHECK(whole[i].bary == line[i].bary);
    }
  }
}
