// Sources that are so near to a vertex or an edge that rounding has a say.
#include "tests/fixtures/beside_corners.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>

#include "core/base/tolerances.h"
#include "tests/core/curves/curve_fixtures.h"

using namespace geodesic;
using fixtures::Surface;
using fixtures::test_seed;
using fixtures::turned_plane;

TEST_CASE("SourcesBesideCornersHaveTheDistancesOfTheClosedForm") {
  std::mt19937 random(test_seed());
  constexpr std::array kStretches{1.0, 1.0, 10.0, 1000.0};
  for (int round = 0; round < 400; ++round) {
    CAPTURE(round);
    TriangleSoup soup = turned_plane(4 + random() % 4, 4 + random() % 4, random);
    const double stretch = kStretches[random() % kStretches.size()];
    for (Vec3& position : soup.positions) position.x *= stretch;
    const Surface surface(soup);
    const Mesh& mesh = surface.mesh();
    const auto face = static_cast<std::uint32_t>(random() % mesh.face_count());
    const SurfacePoint from = fixtures::point_beside(surface, face, random() % 3, random);
    const Vec3 position = position_of(mesh, from);
    const double extent = distance(mesh.box().min, mesh.box().max);
    CAPTURE(from.bary[0]);
    CAPTURE(from.bary[1]);
    CAPTURE(from.bary[2]);
    for (const Method method : {Method::exact, Method::chen_han, Method::back_traced}) {
      CAPTURE(static_cast<int>(method));
      const Field field = surface.field_by(method, {Source{from, 0}});
      const double most_off = method == Method::back_traced ? 0.05 : tolerance::kSamePath;
      for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const double truth = distance(mesh.positions()[v], position);
        CHECK(std::abs(field.distance[v] - truth) <=
              most_off * truth + tolerance::kSamePath * extent);
      }
    }
  }
}

TEST_CASE("PointsThatRoundingAloneKeepsFromACornerAreThere") {
  std::mt19937 random(test_seed());
  const Surface surface(turned_plane(5, 5, random));
  for (std::size_t corner = 0; corner < 3; ++corner) {
    std::array<double, 3> bary{};
    bary[corner] = 3;
    bary[(corner + 1) % 3] = 1e-14;
    bary[(corner + 2) % 3] = 1e-15;
    const SurfacePoint point = snapped_point(surface.adjacency(), 4, bary);
    CHECK(point.vertex == surface.adjacency().face(4).vertex[corner]);
    bary[(corner + 1) % 3] = 1;
    const SurfacePoint on_side = snapped_point(surface.adjacency(), 4, bary);
    CHECK(!on_side.at_vertex());
    CHECK(on_side.bary[(corner + 2) % 3] == 0);
    CHECK(on_side.bary[corner] == doctest::Approx(0.75));
    bary[(corner + 2) % 3] = 1e-9;
    CHECK(snapped_point(surface.adjacency(), 4, bary).bary[(corner + 2) % 3] > 0);
  }
}
