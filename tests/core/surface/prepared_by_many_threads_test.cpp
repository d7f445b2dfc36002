// A mesh built and prepared on several threads: the same bits, however many there are.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>

#include "core/base/team.h"
#include "core/mesh/mesh.h"
#include "core/mesh/shapes.h"
#include "core/surface/adjacency.h"
#include "tests/fixtures/edges_to_flip.h"
#include "tests/fixtures/helping_threads.h"
#include "tests/fixtures/same_adjacency.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::HelpingThreads;

namespace {

// Some blocks of faces (base/team.h).
std::uint32_t side_of_blocks(std::mt19937& random) { return 150 + random() % 100; }

TriangleSoup stretched_terrain(std::mt19937& random) {
  TriangleSoup soup = shapes::terrain(side_of_blocks(random), 20, random());
  const double factor = 1 + random() % 40;
  for (Vec3& p : soup.positions) p.x *= factor;
  return soup;
}

// With edges of many faces, vertices at which faces meet in nothing else, faces given twice, and
// neighbours in different blocks.
TriangleSoup thrown_together(std::mt19937& random) {
  TriangleSoup soup = shapes::terrain(side_of_blocks(random), 8, random());
  const auto count = static_cast<std::uint32_t>(soup.positions.size());
  for (std::size_t i = soup.faces.size() / 3; i > 0; --i) {
    const std::size_t chosen = random() % soup.faces.size();
    if (random() % 3 == 0) soup.faces.push_back(Triangle{soup.faces[chosen]});
    auto& face = soup.faces[chosen];
    if (random() % 2 == 0) std::swap(face[0], face[1]);
    if (random() % 5 == 0) face[random() % 3] = random() % count;
  }
  return soup;
}

struct PreparedMesh {
  std::shared_ptr<const Mesh> mesh;
  Adjacency adjacency;
};

PreparedMesh prepared(const TriangleSoup& soup, Weld weld, Team* team) {
  const Cancel cancel([] { return false; }, {}, nullptr, team);
  auto mesh = Mesh::build(soup, weld, cancel);
  REQUIRE(mesh);
  auto shared = std::make_shared<const Mesh>(std::move(*mesh));
  auto adjacency = Adjacency::build(shared, cancel);
  REQUIRE(adjacency);
  return {std::move(shared), std::move(*adjacency)};
}

void check_threads(std::mt19937& random, const TriangleSoup& soup, bool is_thin) {
  const Weld weld = random() % 2 == 0 ? Weld::by_position : Weld::off;
  const PreparedMesh alone = prepared(soup, weld, nullptr);
  REQUIRE(alone.mesh->face_count() > kBlock);
  if (!is_thin) CHECK(fixtures::edges_to_flip(alone.adjacency.delaunay()) == 0);
  for (const std::size_t threads : {std::size_t{2}, 3 + random() % 14}) {
    CAPTURE(threads);
    Team team(threads, 0);
    // Fewer, or none, may come than were expected.
    const HelpingThreads helping(team, random() % 3);
    const PreparedMesh together = prepared(soup, weld, &team);
    fixtures::check_same(together.adjacency, alone.adjacency);
  }
}

}  // namespace

TEST_CASE("AMeshIsPreparedToTheSameBitsOnAnyNumberOfThreads") {
  std::mt19937 random(fixtures::test_seed());
  SUBCASE("like a scan, in any order") {
    const TriangleSoup terrain = shapes::terrain(side_of_blocks(random), 12, random());
    check_threads(random, terrain, false);
    check_threads(random, shapes::shuffled(terrain, random()), false);
  }
  SUBCASE("of thin faces, of which most are flipped") {
    check_threads(random, stretched_terrain(random), true);
  }
  SUBCASE("of faces thrown together") { check_threads(random, thrown_together(random), true); }
}

TEST_CASE("PreparingOnSeveralThreadsEndsWhenItIsToldTo") {
  std::mt19937 random(fixtures::test_seed());
  const TriangleSoup soup = shapes::shuffled(shapes::terrain(200, 12, random()), random());
  for (int i = 0; i < 20; ++i) {
    int left = static_cast<int>(random() % 200);
    const int asked_before_end = left;
    CAPTURE(asked_before_end);
    Team team(3, 0);
    const HelpingThreads helping(team, 2);
    const Cancel cancel([&left] { return left-- <= 0; }, {}, nullptr, &team);
    auto mesh = Mesh::build(soup, Weld::by_position, cancel);
    if (!mesh) {
      CHECK(mesh.error().code == ErrorCode::cancelled);
      continue;
    }
    const auto adjacency = Adjacency::build(std::make_shared<const Mesh>(std::move(*mesh)), cancel);
    if (!adjacency) CHECK(adjacency.error().code == ErrorCode::cancelled);
  }
}
