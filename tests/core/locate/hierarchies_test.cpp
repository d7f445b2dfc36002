// The engine's own hierarchy of boxes against the quickest one, which is Embree's where the engine
// is built with it: answers are the same to the last bit.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "core/locate/closest_point.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

using Hierarchy = ClosestPointIndex::Hierarchy;

std::shared_ptr<const ClosestPointIndex> index_of(const Surface& surface, Hierarchy hierarchy) {
  auto index = ClosestPointIndex::build(surface.shared(), Cancel(), hierarchy);
  REQUIRE(index.has_value());
  return *index;
}

void check_same(const SurfacePoint& a, const SurfacePoint& b) {
  CHECK(a.face == b.face);
  CHECK(a.vertex == b.vertex);
  for (std::size_t c = 0; c < 3; ++c) CHECK(a.bary[c] == b.bary[c]);
}

}  // namespace

TEST_CASE("BothHierarchiesGiveTheSameAnswers") {
  std::mt19937 random(fixtures::test_seed());
  std::uniform_real_distribution<double> part(-0.2, 1.2);
  std::uniform_real_distribution<double> ahead(-1, 1);
  int hits = 0;
  for (int round = 0; round < 60; ++round) {
    CAPTURE(round);
    auto soup = fixtures::RandomMesh(random()).soup();
    const double scale = std::pow(10.0, static_cast<int>(random() % 25) - 12);
    for (Vec3& p : soup.positions) p = scale * p;
    const Surface surface(soup);
    const auto quickest = index_of(surface, Hierarchy::quickest);
    const auto boxes = index_of(surface, Hierarchy::boxes);
    const Box& box = surface.mesh().box();
    const Vec3 size = box.max - box.min;
    const auto somewhere = [&] {
      return box.min + Vec3{part(random) * size.x, part(random) * size.y, part(random) * size.z};
    };
    for (int i = 0; i < 50; ++i) {
      // Every fifth in a vertex, where many faces are as close.
      const Vec3 from = i % 5 == 0
                            ? surface.mesh().positions()[random() % surface.mesh().vertex_count()]
                            : somewhere();
      const ClosestPoint closest = quickest->closest(from);
      const ClosestPoint by_boxes = boxes->closest(from);
      CHECK(closest.distance == by_boxes.distance);
      check_same(closest.point, by_boxes.point);

      const double far = i % 3 == 0 ? 1e6 : 1;
      const Vec3 direction =
          i % 7 == 0 ? Vec3{0, 0, -1} : Vec3{ahead(random), ahead(random), ahead(random)};
      const Vec3 origin = somewhere() - far * norm(size) * direction;
      const auto hit = quickest->first_hit(origin, direction);
      const auto hit_by_boxes = boxes->first_hit(origin, direction);
      REQUIRE(hit.has_value() == hit_by_boxes.has_value());
      if (!hit) continue;
      ++hits;
      CHECK(hit->distance == hit_by_boxes->distance);
      check_same(hit->point, hit_by_boxes->point);
    }
  }
  CHECK(hits > 300);
}

TEST_CASE("TheBoxHierarchyCanBeCancelled") {
  const Surface surface(shapes::terrain(200, 3, 1));
  const auto boxes = index_of(surface, Hierarchy::boxes);
  const Vec3 far_up{100, 100, 300};
  int questions = 0;
  const Cancel at_once([&] { return ++questions > 0; });
  const auto stopped = ClosestPointIndex::build(surface.shared(), at_once, Hierarchy::boxes);
  REQUIRE(!stopped.has_value());
  CHECK(stopped.error().code == ErrorCode::cancelled);
  CHECK(boxes->closest(far_up, Cancel()).has_value());
}
