// Memory that is kept from one exact query to the next is of no consequence, whatever was
// built, dropped and built again in between, perhaps at the same address.
#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/exact/field.h"
#include "core/mesh/shapes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;

namespace {

TriangleSoup stretched_terrain(std::uint32_t side, double height, std::uint32_t seed) {
  TriangleSoup soup = shapes::terrain(side, height, seed);
  for (Vec3& p : soup.positions) p.x *= 8;
  return soup;
}

std::shared_ptr<const Mesh> mesh_of(const TriangleSoup& soup) {
  return std::make_shared<const Mesh>(std::move(*Mesh::build(soup)));
}

std::vector<double> distances(const Adjacency& adjacency, const SurfacePoint& from, bool details,
                              ExactScratch& scratch) {
  FieldLimits limits;
  limits.keep_details = details;
  const Source source{from, 0};
  const auto field = exact_field(adjacency, {&source, 1}, limits, scratch, Cancel());
  REQUIRE(field);
  return field->distance.values();
}

// As a fresh scratch has it, bit by bit.
void check_round(const Adjacency& adjacency, std::uint32_t v, bool details, ExactScratch& kept) {
  ExactScratch fresh;
  const SurfacePoint from = point_at_vertex(adjacency, v);
  CHECK(distances(adjacency, from, details, kept) == distances(adjacency, from, details, fresh));
}

}  // namespace

// The mesh stays, and its adjacency is built anew: its arrays lie where those of the last one
// lay, or where the Delaunay triangulation's did.
TEST_CASE("KeptFramesAreNotThoseOfAnAdjacencyThatIsGone") {
  const auto mesh = mesh_of(stretched_terrain(4, 4, 3));
  ExactScratch kept;
  for (int round = 0; round < 200; ++round) {
    CAPTURE(round);
    const Adjacency adjacency = Adjacency::build(mesh);
    check_round(adjacency, 0, round % 2 == 0, kept);
  }
}

TEST_CASE("KeptFramesAreNotThoseOfOtherSurfacesOfAnySize") {
  std::mt19937 random(fixtures::test_seed());
  for (int trial = 0; trial < fixtures::all_or(20, 4); ++trial) {
    const std::uint32_t side = 3 + random() % 10;
    const auto mesh = mesh_of(stretched_terrain(side, 1.0 + random() % 6, random()));
    const auto other = mesh_of(stretched_terrain(side, 1.0 + random() % 6, random()));
    ExactScratch kept;
    for (int round = 0; round < 20; ++round) {
      CAPTURE(side);
      CAPTURE(trial);
      CAPTURE(round);
      const Adjacency adjacency = Adjacency::build(random() % 3 == 0 ? other : mesh);
      // A copy has the same arrays elsewhere, and may be what is left of it.
      auto copy = std::make_unique<const Adjacency>(adjacency);
      const auto v = static_cast<std::uint32_t>(random() % adjacency.mesh().vertex_count());
      check_round(random() % 2 == 0 ? adjacency : *copy, v, random() % 2 == 0, kept);
      copy.reset();
      check_round(adjacency, v, random() % 2 == 0, kept);
    }
  }
}

// On the same surface the frames are kept, and that has no say either.
TEST_CASE("KeptFramesServeTheSameSurfaceAgain") {
  const auto mesh = mesh_of(stretched_terrain(12, 4, 3));
  const Adjacency adjacency = Adjacency::build(mesh);
  ExactScratch kept;
  for (std::uint32_t v = 0; v < 40; ++v) check_round(adjacency, v, v % 3 == 0, kept);
}
