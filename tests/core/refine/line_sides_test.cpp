#include "core/refine/line_sides.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/base/memory_budget.h"
#include "core/locate/closest_point.h"
#include "core/mesh/shapes.h"
#include "tests/core/curves/curve_fixtures.h"
#include "tests/core/refine/cut_surface.h"
#include "tests/core/refine/lines_on_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/tube.h"

using namespace geodesic;
using fixtures::kPlenty;
using fixtures::random_line;
using fixtures::RandomMesh;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

constexpr std::uint32_t kSide = 11;

// A sheared square of the xy plane.
TriangleSoup sheared_plane(RandomMesh& random) {
  TriangleSoup soup = shapes::plane(
      kSide, kSide, random.unit() < 0.5 ? shapes::Diagonal::rising : shapes::Diagonal::falling);
  const double shear = random.unit() - 0.5;
  const double width = 0.3 + random.unit();
  for (Vec3& p : soup.positions) p = {p.x + shear * p.y, width * p.y, 0};
  return soup;
}

// The closed curve through points, as it is drawn for a field.
SurfacePolyline round_curve(const Surface& surface, const std::vector<SurfacePoint>& points) {
  SourceLines lines;
  std::vector<Source> sources;
  SolveScratch scratch;
  REQUIRE(
      add_curve(surface.adjacency(), points, true, 0, kPlenty, lines, sources, scratch, Cancel()));
  SurfacePolyline line;
  for (const Source& source : sources) line.push_back(source.point);
  return line;
}

LineSides sides_of(const Adjacency& adjacency, const SurfacePolyline& line) {
  auto sides = LineSides::find(adjacency, line, kPlenty, Cancel());
  REQUIRE(sides);
  return std::move(*sides);
}

// By the crossings of a ray along x, how often it is an odd number; nothing next to the line.
std::optional<bool> is_in_polygon(const std::vector<Vec3>& polygon, Vec3 p) {
  if (fixtures::to_polyline(p, polygon, true) < 1e-6) return std::nullopt;
  bool is_in = false;
  for (std::size_t c = 0; c < polygon.size(); ++c) {
    const Vec3 a = polygon[c];
    const Vec3 b = polygon[(c + 1) % polygon.size()];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) {
      is_in = !is_in;
    }
  }
  return is_in;
}

bool has_inside(const LineSides& sides, const SurfacePoint& point) {
  const Cancel never;
  Poll poll(never);
  return sides.is_inside(point, poll);
}

SurfacePoint random_point_of(RandomMesh& random, const Adjacency& adjacency, std::uint32_t face) {
  return point_on_face(adjacency, face, {random.unit(), random.unit(), random.unit() + 0.01});
}

}  // namespace

TEST_CASE("SidesOfAPolygonInAPlaneAreThoseOfItsCrossings") {
  std::uint32_t found_inside = 0;
  for (std::uint32_t i = 0; i < 20; ++i) {
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    const Surface plane(sheared_plane(random));
    // Corners round the plane's middle, so far apart that it is simple; some at vertices.
    const std::uint32_t corners = 3 + random.below(2);
    std::vector<SurfacePoint> points;
    std::vector<Vec3> polygon;
    for (std::uint32_t c = 0; c < corners; ++c) {
      const double angle = 2 * std::numbers::pi * (c + 0.3 * random.unit()) / corners;
      const double radius = 3 + random.unit();
      const double x = 5 + radius * std::cos(angle);
      const double y = 5 + radius * std::sin(angle);
      const auto column = static_cast<std::uint32_t>(x);
      const auto row = static_cast<std::uint32_t>(y);
      if (random.unit() < 0.3) {
        points.push_back(plane.at(row * kSide + column));
      } else {
        points.push_back(random_point_of(random, plane.adjacency(),
                                         plane.mesh().face_of_source(2 * (row * 10 + column))));
      }
      polygon.push_back(position_of(plane.mesh(), points.back()));
    }
    double area = 0;
    for (std::uint32_t c = 1; c + 1 < corners; ++c) {
      area += 0.5 * cross(polygon[c] - polygon[0], polygon[c + 1] - polygon[0]).z;
    }
    if (area > 0.49 * plane.mesh().area()) continue;
    const SurfacePolyline line = round_curve(plane, points);
    const LineSides sides = sides_of(plane.adjacency(), line);
    for (std::uint32_t v = 0; v < plane.mesh().vertex_count(); ++v) {
      const auto is_in = is_in_polygon(polygon, plane.mesh().positions()[v]);
      if (!is_in) continue;
      CHECK(sides.is_inside(v) == *is_in);
      CHECK(has_inside(sides, point_at_vertex(plane.adjacency(), v)) == *is_in);
      found_inside += sides.is_inside(v) ? 1 : 0;
    }
    for (std::uint32_t k = 0; k < 300; ++k) {
      const SurfacePoint point =
          random_point_of(random, plane.adjacency(), random.below(plane.mesh().face_count()));
      const auto is_in = is_in_polygon(polygon, position_of(plane.mesh(), point));
      if (is_in) CHECK(has_inside(sides, point) == *is_in);
      found_inside += is_in && *is_in ? 1 : 0;
    }
  }
  CHECK(found_inside > 0);
}

TEST_CASE("SidesOfALineOnASurfaceThatOthersHaveSplit") {
  for (std::uint32_t i = 0; i < 10; ++i) {
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    const Surface plane(sheared_plane(random));
    std::vector<SurfacePolyline> others;
    for (int k = 0; k < 3; ++k) others.push_back(random_line(random, plane.adjacency(), 20));
    auto refined = refine_along(plane.adjacency(), others, kPlenty, Cancel());
    REQUIRE(refined);
    const auto mesh = std::make_shared<const Mesh>(std::move(refined->mesh));
    const Adjacency split = Adjacency::build(mesh);
    // Round a vertex of the file by the vertices about it.
    const std::uint32_t hub = mesh->vertex_of_source()[5 * kSide + 5];
    const Vec3 middle = mesh->positions()[hub];
    std::vector<std::pair<double, std::uint32_t>> about;
    for (const std::uint32_t corner : split.corners(hub)) {
      for (const std::uint32_t v : split.face(face_of(corner)).vertex) {
        const Vec3 p = mesh->positions()[v] - middle;
        if (v != hub) about.emplace_back(std::atan2(p.y, p.x), v);
      }
    }
    std::sort(about.begin(), about.end());
    about.erase(std::unique(about.begin(), about.end()), about.end());
    SurfacePolyline line;
    std::vector<Vec3> polygon;
    for (const auto& [angle, v] : about) {
      line.push_back(point_at_vertex(split, v));
      polygon.push_back(mesh->positions()[v]);
    }
    line.push_back(line.front());
    const LineSides sides = sides_of(split, line);
    CHECK(sides.is_inside(hub));
    for (std::uint32_t f = 0; f < mesh->face_count(); ++f) {
      const SurfacePoint point = random_point_of(random, split, f);
      const auto is_in = is_in_polygon(polygon, position_of(*mesh, point));
      if (is_in) CHECK(has_inside(sides, point) == *is_in);
    }
  }
}

TEST_CASE("InsideOfALatitudeIsTheSmallerCap") {
  std::mt19937 random(test_seed());
  const Surface sphere(shapes::icosphere(3));
  const std::shared_ptr<const ClosestPointIndex> index =
      *ClosestPointIndex::build(sphere.shared(), Cancel());
  for (const double height : {-0.6, -0.2, 0.3, 0.8}) {
    std::vector<SurfacePoint> points;
    const double phase = random() / 4294967296.0;
    for (int k = 0; k < 24; ++k) {
      const double angle = std::numbers::pi / 12 * (k + phase);
      const double radius = std::sqrt(1 - height * height);
      points.push_back(
          index->closest({radius * std::cos(angle), radius * std::sin(angle), height}, Cancel())
              ->point);
    }
    const LineSides sides = sides_of(sphere.adjacency(), round_curve(sphere, points));
    for (std::uint32_t v = 0; v < sphere.mesh().vertex_count(); ++v) {
      const double z = sphere.mesh().positions()[v].z;
      if (std::abs(z - height) < 0.05) continue;
      CHECK(sides.is_inside(v) == (height > 0 ? z > height : z < height));
    }
  }
}

TEST_CASE("ALineRoundATubeHasNoSides") {
  constexpr std::uint32_t kAround = 8;
  const Surface knot(shapes::torus_knot(40, kAround, 0.3));
  std::vector<SurfacePoint> ring;
  for (std::uint32_t k = 0; k < kAround; ++k) ring.push_back(knot.at(k));
  const auto refused =
      LineSides::find(knot.adjacency(), round_curve(knot, ring), kPlenty, Cancel());
  REQUIRE(!refused);
  CHECK(refused.error().code == ErrorCode::value_out_of_range);
  // A tube that is open divides.
  const Surface tube(fixtures::tube(kAround, 3, 4));
  ring.clear();
  for (std::uint32_t k = 0; k < kAround; ++k) ring.push_back(tube.at(kAround + k));
  const LineSides sides = sides_of(tube.adjacency(), round_curve(tube, ring));
  for (std::uint32_t s = 0; s < 5 * kAround; ++s) {
    CHECK(sides.is_inside(tube.vertex(s)) == (s < kAround));
  }
}

// Between a place and a vertex that is farther from the line than from that place, there is none of
// the line, on whatever surface.
TEST_CASE("SidesChangeAtTheLineAlone") {
  std::uint32_t separated = 0;
  std::uint32_t seen_inside = 0;
  for (std::uint32_t i = 0; i < 30; ++i) {
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    const Adjacency& adjacency = surface.adjacency();
    fixtures::LineQuestion question(surface);
    std::vector<SurfacePoint> points;
    for (std::uint32_t k = 0; k < 3 + i % 3; ++k) {
      points.push_back(
          random_point_of(random, adjacency, random.below(surface.mesh().face_count())));
    }
    SourceLines lines;
    std::vector<Source> sources;
    SolveScratch scratch;
    if (!add_curve(adjacency, points, true, 0, kPlenty, lines, sources, scratch, Cancel())) {
      continue;  // on several pieces
    }
    SurfacePolyline line;
    for (const Source& source : sources) line.push_back(source.point);
    const auto sides = LineSides::find(adjacency, line, kPlenty, Cancel());
    if (!sides) {
      CHECK(sides.error().code == ErrorCode::value_out_of_range);
      continue;
    }
    ++separated;
    question.curve(points, true);
    const Field field = question.field(Method::exact);
    const auto positions = surface.mesh().positions();
    for (std::uint32_t f = 0; f < surface.mesh().face_count(); ++f) {
      const SurfacePoint point = random_point_of(random, adjacency, f);
      const Vec3 here = position_of(surface.mesh(), point);
      for (const std::uint32_t v : adjacency.face(f).vertex) {
        const double away = distance(here, positions[v]);
        if (field.distance[v] == kUnreached || adjacency.is_pinched(v)) continue;
        if (field.distance[v] < 1e-6 || away > 0.99 * field.distance[v]) continue;
        CHECK(has_inside(*sides, point) == sides->is_inside(v));
        seen_inside += sides->is_inside(v) ? 1 : 0;
      }
    }
  }
  CHECK(separated > 0);
  CHECK(seen_inside > 0);
}

TEST_CASE("SidesAreNotLookedForWithoutLeaveAndMemory") {
  const Surface plane(shapes::terrain(60, 3, 5));
  const SurfacePolyline line =
      round_curve(plane, {plane.at(70), plane.at(60 * 50 + 10), plane.at(60 * 40 + 50)});
  std::uint64_t asked = 0;
  std::uint64_t most = ~std::uint64_t{0};
  const Cancel cancel([&] { return ++asked > most; });
  REQUIRE(LineSides::find(plane.adjacency(), line, kPlenty, cancel));
  const std::uint64_t all = asked;
  CHECK(all > 4);
  for (const std::uint64_t few : {std::uint64_t{0}, all / 2, all - 1}) {
    asked = 0;
    most = few;
    const auto stopped = LineSides::find(plane.adjacency(), line, kPlenty, cancel);
    REQUIRE(!stopped);
    CHECK(stopped.error().code == ErrorCode::cancelled);
  }
  MemoryBudget none([](std::uint64_t) {
    return std::optional(Error{ErrorCode::too_large, "no room", {}, {}, {}});
  });
  CHECK_FALSE(LineSides::find(plane.adjacency(), line, kPlenty, Cancel({}, {}, &none)));
  const LineSides sides = sides_of(plane.adjacency(), line);
  const Cancel at_once([] { return true; });
  Poll poll(at_once, 1);
  for (std::uint32_t f = 0; f < plane.mesh().face_count(); ++f) {
    (void)sides.is_inside(point_on_face(plane.adjacency(), f, {0.2, 0.3, 0.5}), poll);
  }
  CHECK(poll.stopped());  // in a face that the line has split
  const auto crossed = LineSides::find(plane.adjacency(), line, 3, Cancel());
  REQUIRE(!crossed);
  CHECK(crossed.error().code == ErrorCode::too_large);
}
