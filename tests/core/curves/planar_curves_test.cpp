// Distances from curves in a plane, where their closed form is known.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/core/curves/curve_fixtures.h"
#include "tests/fixtures/beside_corners.h"

using namespace geodesic;
using fixtures::LineQuestion;
using fixtures::point_beside;
using fixtures::some_point;
using fixtures::Surface;
using fixtures::test_seed;
using fixtures::to_polyline;
using fixtures::turned_plane;

namespace {

constexpr double kExactInPlane = 1e-9;
// A curve is a shortest path, so its length is exact. But a path that passes a vertex at 1e-6 is
// longer by 1e-12 only if it goes through it, and such a way is taken as the same.
constexpr double kBeside = 1e-5;

struct PlaneAndCurve {
  Surface surface;
  std::vector<SurfacePoint> points;
  std::vector<Vec3> line;
  bool is_closed;
};

PlaneAndCurve some_curve(std::mt19937& random) {
  PlaneAndCurve made{
      Surface(turned_plane(6 + random() % 8, 5 + random() % 8, random)), {}, {}, random() % 2 == 0};
  const std::size_t count = 2 + random() % 4;
  for (std::size_t i = 0; i < count; ++i) {
    made.points.push_back(some_point(made.surface, random));
    made.line.push_back(position_of(made.surface.mesh(), made.points.back()));
  }
  return made;
}

// By the exact methods, all vertices of a plane are as far from the line between two points as they
// are by the closed form.
void check_segment(const Surface& plane, const std::vector<SurfacePoint>& ends, double most_off) {
  const Mesh& mesh = plane.mesh();
  const std::vector<Vec3> line{position_of(mesh, ends[0]), position_of(mesh, ends[1])};
  LineQuestion question(plane);
  (void)question.curve(ends, false);
  for (const Method method : {Method::exact, Method::chen_han}) {
    const Field field = question.field(method);
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
      const double wanted = to_polyline(mesh.positions()[v], line, false);
      CHECK(std::abs(field.distance[v] - wanted) < most_off);
    }
  }
}

}  // namespace

TEST_CASE("PlanarCurvesHaveTheDistancesOfTheClosedForm") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 20; ++round) {
    CAPTURE(round);
    const PlaneAndCurve made = some_curve(random);
    LineQuestion question(made.surface);
    const double length = question.curve(made.points, made.is_closed);
    double sum = 0;
    for (std::size_t i = 0; i + 1 < made.line.size() + (made.is_closed ? 1 : 0); ++i) {
      sum += norm(made.line[(i + 1) % made.line.size()] - made.line[i]);
    }
    CHECK(length == doctest::Approx(sum).epsilon(kExactInPlane));
    for (const Method method : {Method::exact, Method::chen_han}) {
      const Field field = question.field(method);
      CHECK(field.reached == made.surface.mesh().vertex_count());
      double worst = 0;
      for (std::uint32_t v = 0; v < made.surface.mesh().vertex_count(); ++v) {
        const double wanted =
            to_polyline(made.surface.mesh().positions()[v], made.line, made.is_closed);
        worst = std::max(worst, std::abs(field.distance[v] - wanted));
      }
      for (int i = 0; i < 60; ++i) {
        const SurfacePoint point = some_point(made.surface, random);
        const Vec3 position = position_of(made.surface.mesh(), point);
        const double wanted = to_polyline(position, made.line, made.is_closed);
        worst = std::max(worst, std::abs(question.at(field, point) - wanted));
        const auto path = question.path(field, point);
        REQUIRE(path);
        CHECK(std::abs(path->length - wanted) < kBeside);
        CHECK(norm(path->points.back().position - position) < kExactInPlane);
        CHECK(to_polyline(path->points.front().position, made.line, made.is_closed) < kBeside);
      }
      CHECK(worst < kBeside);
    }
  }
}

TEST_CASE("CurvesNextToSidesAndCornersHaveTheDistancesOfTheClosedForm") {
  std::mt19937 random(test_seed() + 3);
  for (int round = 0; round < 150; ++round) {
    CAPTURE(round);
    const Surface surface(turned_plane(4 + random() % 4, 4 + random() % 4, random));
    const auto face = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    const std::size_t side = random() % 3;
    const SurfacePoint from = point_beside(surface, face, side, random);
    check_segment(surface, {from, point_beside(surface, face, side, random)}, kBeside);
  }
}

TEST_CASE("CurvesOnGridsWhereWaysRunAlongEdgesHaveTheDistancesOfTheClosedForm") {
  std::mt19937 random(test_seed() + 4);
  for (int round = 0; round < 40; ++round) {
    CAPTURE(round);
    const auto side = static_cast<std::uint32_t>(3 + random() % 5);
    TriangleSoup soup = shapes::plane(side, side);
    soup.faces.clear();
    for (std::uint32_t a = 0; a + side + 1 < side * side; ++a) {
      if (a % side == side - 1) continue;
      const std::array<std::uint32_t, 4> square{a, a + 1, a + side + 1, a + side};
      const std::uint32_t first = random() % 2;  // of the diagonal
      for (const std::uint32_t c : {first, first + 2}) {
        soup.faces.push_back({square[c], square[(c + 1) % 4], square[(c + 2) % 4]});
      }
    }
    const Surface surface(soup);
    for (int i = 0; i < 10; ++i) {
      const auto a = static_cast<std::uint32_t>(random() % (side * side));
      const auto b = static_cast<std::uint32_t>(random() % (side * side));
      CAPTURE(a);
      CAPTURE(b);
      check_segment(surface, {surface.at(a), surface.at(b)}, kExactInPlane);
    }
  }
}

TEST_CASE("PlanarCurvesByOtherMethodsAreNear") {
  std::mt19937 random(test_seed() + 1);
  for (int round = 0; round < 12; ++round) {
    CAPTURE(round);
    const PlaneAndCurve made = some_curve(random);
    LineQuestion question(made.surface);
    (void)question.curve(made.points, made.is_closed);
    for (const Method method : {Method::back_traced, Method::wavefront, Method::novotni,
                                Method::fast_marching, Method::dijkstra, Method::steiner}) {
      CAPTURE(int(method));
      const Field field = question.field(method);
      for (std::uint32_t v = 0; v < made.surface.mesh().vertex_count(); ++v) {
        const double wanted =
            to_polyline(made.surface.mesh().positions()[v], made.line, made.is_closed);
        CHECK(field.distance[v] > wanted - 1e-3 * (1 + wanted));
        // Edges are about one long. Beyond the ends of the line and between its corners these
        // methods have their own errors, the greatest next to a source inside a face, and along the
        // edges of uneven triangles.
        const bool is_coarse = method == Method::dijkstra || method == Method::fast_marching;
        CHECK(field.distance[v] < (is_coarse ? 2 * wanted + 1 : 1.1 * wanted + 0.5));
      }
    }
  }
}

TEST_CASE("PlanarBoundariesAreAsFarAsTheNearestSide") {
  std::mt19937 random(test_seed() + 2);
  const Surface surface(turned_plane(9, 7, random));
  LineQuestion question(surface);
  question.boundary();
  // The corners of the rectangle are the ends of its longest diagonals.
  std::vector<Vec3> corners;
  const auto positions = surface.mesh().positions();
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    double angles = 0;
    for (const std::uint32_t corner : surface.adjacency().corners(v)) {
      const FaceRecord& face = surface.adjacency().face(face_of(corner));
      angles += std::atan2(face.area2, face.dot[corner_of(corner)]);
    }
    if (angles < 0.51 * std::numbers::pi) corners.push_back(positions[v]);
  }
  REQUIRE(corners.size() == 4);
  // In a ring: the one that is opposite the first goes third.
  std::sort(corners.begin() + 1, corners.end(),
            [&](Vec3 a, Vec3 b) { return norm(a - corners[0]) < norm(b - corners[0]); });
  std::swap(corners[2], corners[3]);
  const Field field = question.field(Method::exact);
  for (int i = 0; i < 300; ++i) {
    const SurfacePoint point = some_point(surface, random);
    const double wanted = to_polyline(position_of(surface.mesh(), point), corners, true);
    CHECK(std::abs(question.at(field, point) - wanted) < kExactInPlane);
  }
}
