// Surfaces with vertices added where they are flat: the same surface, without needles.
#include "core/surface/refined_surface.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <vector>

#include "core/exact/surface.h"
#include "core/field/window_table.h"
#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "core/paths/trace_path.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/turned_part.h"

using namespace geodesic;
using fixtures::drawn_point;
using fixtures::kSpoils;
using fixtures::Spoiled;
using fixtures::Surface;
using fixtures::turned_part;

namespace {

double angle_sum(const Triangulation& surface, std::uint32_t v) {
  double sum = 0;
  for (const std::uint32_t corner : surface.corners(v)) {
    const FaceRecord& face = surface.faces[face_of(corner)];
    sum += std::atan2(face.area2, face.dot[corner_of(corner)]);
  }
  return sum;
}

bool is_on_boundary(const Triangulation& surface, std::uint32_t v) {
  const auto corners = surface.corners(v);
  return std::any_of(corners.begin(), corners.end(), [&](std::uint32_t corner) {
    const Halfedge before = halfedge(face_of(corner), previous_corner(corner_of(corner)));
    return surface.ring(corner) == corner || surface.ring(before) == before;
  });
}

double area_in_all(std::span<const FaceRecord> faces) {
  double sum = 0;
  for (const FaceRecord& face : faces) sum += face.area2 / 2;
  return sum;
}

// Rings are cycles of halfedges between the same two vertices, which are as long in all faces.
std::size_t check_edges(const Triangulation& surface) {
  std::size_t edges = 0;
  for (std::uint32_t f = 0; f < surface.faces.size(); ++f) {
    const FaceRecord& face = surface.faces[f];
    REQUIRE(std::set(face.vertex.begin(), face.vertex.end()).size() == 3);
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      const std::set<std::uint32_t> ends{face.vertex[c], face.vertex[next_corner(c)]};
      Halfedge least = h;
      int steps = 0;
      for (Halfedge p = surface.ring(h); p != h; p = surface.ring(p)) {
        REQUIRE(++steps < 1000);
        const FaceRecord& other = surface.faces[face_of(p)];
        REQUIRE(ends == std::set<std::uint32_t>{other.vertex[corner_of(p)],
                                                other.vertex[next_corner(corner_of(p))]});
        REQUIRE(other.length2(corner_of(p)) == doctest::Approx(face.length2(c)).epsilon(1e-9));
        least = std::min(least, p);
      }
      if (least == h) ++edges;
    }
  }
  return edges;
}

}  // namespace

TEST_CASE("ARefinedSurfaceIsTheSameSurfaceWithFlatVerticesAdded") {
  const std::uint32_t seed = fixtures::test_seed();
  for (std::uint32_t number = 0; number < 40; ++number) {
    CAPTURE(number);
    std::mt19937 random(seed + number);
    const auto spoiled = static_cast<Spoiled>(number % kSpoils);
    const Surface part(turned_part(random, spoiled));
    const RefinedSurface* const refined = part.adjacency().refined();
    if (refined == nullptr) continue;
    const Triangulation mesh = part.adjacency().triangulation();
    const Triangulation cut = refined->triangulation();
    CHECK(std::abs(area_in_all(cut.faces) / area_in_all(mesh.faces) - 1) <= 1e-11);
    const std::size_t edges = check_edges(cut);
    const std::size_t vertices = cut.corner_begin.size() - 1;
    const std::uint32_t of_mesh = part.mesh().vertex_count();
    CHECK(vertices > of_mesh);
    CHECK(cut.faces.size() <= mesh.faces.size() + 2 * (of_mesh + 33));
    CHECK(edges - part.adjacency().report().edges ==
          (vertices - of_mesh) + (cut.faces.size() - mesh.faces.size()));
    for (std::uint32_t v = 0; v < vertices; ++v) {
      CAPTURE(v);
      if (v < of_mesh) REQUIRE(is_on_boundary(cut, v) == is_on_boundary(mesh, v));
      if (spoiled == Spoiled::lines) continue;  // their angles are what rounding makes of them
      const double sum = angle_sum(cut, v);
      if (v < of_mesh) {
        REQUIRE(std::abs(sum - angle_sum(mesh, v)) < 1e-11);
      } else if (spoiled != Spoiled::fins) {  // where three faces meet in an edge it is 3 pi
        REQUIRE(std::abs(sum - (is_on_boundary(cut, v) ? 1 : 2) * std::numbers::pi) < 1e-11);
      }
    }
  }
}

TEST_CASE("NoNeedlesAreLeftOnRefinedParts") {
  std::mt19937 random(fixtures::test_seed());
  int parts = 0;
  for (int round = 0; round < 20; ++round) {
    const Surface part(turned_part(random, Spoiled::not_at_all));
    if (part.adjacency().refined() == nullptr) continue;
    ++parts;
    const auto faces = part.adjacency().refined()->triangulation().faces;
    const auto needles = std::count_if(faces.begin(), faces.end(), [](const FaceRecord& face) {
      const double radius2 =
          face.length2(0) / face.area2 * (face.length2(1) / face.area2) * face.length2(2) / 4;
      return radius2 > 26 * face.shortest2();
    });
    // One that is as thin as rounding is left, and few of those whose circle no walk came to.
    CHECK(50 * static_cast<std::size_t>(needles) <= faces.size());
  }
  CHECK(parts >= 5);
}

TEST_CASE("ExactDistancesOverARefinedSurfaceAreThoseOverTheMesh") {
  const std::uint32_t seed = fixtures::test_seed();
  int refined = 0;
  int inside = 0;
  int on_edges = 0;
  for (std::uint32_t number = 0; number < 150; ++number) {
    CAPTURE(number);
    std::mt19937 random(seed + 1000 + number);
    const Surface part(turned_part(random, static_cast<Spoiled>(number % kSpoils)));
    const Adjacency& adjacency = part.adjacency();
    if (adjacency.refined() == nullptr) continue;
    const SurfacePoint from = drawn_point(adjacency, random);
    const std::vector<Source> sources{{from, 0}};
    const Cancel never;
    Poll poll(never);
    const Triangulation chosen = exact::surface_for_windows(adjacency, sources, poll);
    if (chosen.faces.data() != adjacency.refined()->triangulation().faces.data()) continue;
    ++refined;
    if (!from.at_vertex()) ++inside;
    if (edge_under(from) != kNone) ++on_edges;
    FieldLimits limits;
    limits.keep_details = false;
    const auto over_refined = part.field_by(Method::exact, sources, limits).distance.values();
    const auto over_mesh = part.field_by(Method::exact, sources, {}).distance.values();
    const auto by_chen_han = part.field_by(Method::chen_han, sources, limits).distance.values();
    for (std::size_t v = 0; v < over_mesh.size(); ++v) {
      CAPTURE(v);
      REQUIRE((over_refined[v] == kUnreached) == (over_mesh[v] == kUnreached));
      if (over_mesh[v] == kUnreached) continue;
      REQUIRE(over_refined[v] == doctest::Approx(over_mesh[v]).epsilon(1e-10));
      REQUIRE(over_refined[v] == doctest::Approx(by_chen_han[v]).epsilon(1e-9));
    }
  }
  CHECK(refined >= 20);
  CHECK(inside >= 10);
  CHECK(on_edges >= 10);
}

// Over the mesh as it is, each window crosses as many needles as there are: 35 kB a vertex.
TEST_CASE("WindowsOnAFrustumTakeLittleMemory") {
  std::mt19937 random(fixtures::test_seed());
  const Surface frustum(turned_part(random, Spoiled::not_at_all, 1500, 2));
  REQUIRE(frustum.adjacency().refined() != nullptr);
  std::uint64_t taken = 0;
  MemoryBudget budget([&taken](std::uint64_t bytes) -> std::optional<Error> {
    taken += bytes;
    return std::nullopt;
  });
  const Cancel counted({}, {}, &budget);
  FieldLimits limits;
  limits.keep_details = false;
  SolveScratch scratch;
  const std::vector<Source> sources{
      {point_at_vertex(frustum.adjacency(), random() % frustum.mesh().vertex_count()), 0}};
  REQUIRE(solve_field(Method::exact, {}, frustum.adjacency(), sources, limits, scratch, counted));
  const std::uint64_t of_vertex = taken / frustum.mesh().vertex_count();
  MESSAGE(of_vertex << " bytes a vertex");
  CHECK(of_vertex < 10'000);
}

// How far the corner `c` of the mesh's face is, over the refined surface, where both are in a face.
std::optional<double> to_corner(const Adjacency& adjacency, const SurfacePoint& point,
                                std::uint32_t c, Poll& poll) {
  const Triangulation refined = adjacency.refined()->triangulation();
  const std::uint32_t v = adjacency.face(point.face).vertex[c];
  for (const auto& place : exact::places_on(adjacency, refined, point, poll)) {
    const auto& corners = refined.faces[place.face].vertex;
    const auto at = std::find(corners.begin(), corners.end(), v);
    if (at != corners.end()) return place.to_corner[std::size_t(at - corners.begin())];
  }
  return std::nullopt;
}

TEST_CASE("PlacesBesideACornerKeepTheirDigits") {
  std::mt19937 random(fixtures::test_seed());
  int beside = 0;
  for (int i = 0; i < 300; ++i) {
    CAPTURE(i);
    const Surface part(turned_part(random, Spoiled::not_at_all));
    const Adjacency& adjacency = part.adjacency();
    if (adjacency.refined() == nullptr) continue;
    const auto face = static_cast<std::uint32_t>(random() % part.mesh().face_count());
    const auto c = static_cast<std::uint32_t>(random() % 3);
    const double small = std::pow(10, -9 * fixtures::fraction(random));
    std::array<double, 3> weights{};
    for (double& weight : weights) weight = small * (0.1 + fixtures::fraction(random));
    weights[c] = 1;
    const SurfacePoint point = point_on_face(adjacency, face, weights);
    const Cancel never;
    Poll poll(never);
    const auto over_refined = to_corner(adjacency, point, c, poll);
    if (!over_refined) continue;
    ++beside;
    CHECK(*over_refined ==
          doctest::Approx(distance_to_corner(part.mesh(), point, c)).epsilon(1e-7));
  }
  CHECK(beside >= 100);
}

TEST_CASE("PointsAndPathsByWindowsOfARefinedSurfaceAreExact") {
  const std::uint32_t seed = fixtures::test_seed();
  int parts = 0;
  int points = 0;
  int known = 0;
  int followed = 0;
  for (std::uint32_t number = 0; number < 150; ++number) {
    CAPTURE(number);
    std::mt19937 random(seed + 2000 + number);
    const auto spoiled = static_cast<Spoiled>(number % kSpoils);
    const Surface part(turned_part(random, spoiled));
    const Adjacency& adjacency = part.adjacency();
    const std::vector<Source> sources{{drawn_point(adjacency, random), 0}};
    const Field automatic = part.field_by(Method::back_traced, sources, {});
    if (!automatic.kept_windows || !automatic.kept_windows->is_refined) continue;
    ++parts;
    const Field exact = part.field_by(Method::exact, sources, {});
    const Cancel never;
    Poll poll(never);
    const WindowPaths ways(adjacency, automatic, poll);
    for (int k = 0; k < 10; ++k) {
      CAPTURE(k);
      const SurfacePoint target = drawn_point(adjacency, random);
      const double d = PointArrivals(adjacency, exact).distance_at(target);
      if (d == kUnreached) continue;
      ++points;
      const double rounding = 1e-6 * d + 1e-10;
      const auto told = ways.distance_at(target);
      if (told) {
        ++known;
        CHECK(std::abs(*told - d) <= rounding);
      }
      const auto way = ways.way_to(target);
      if (!way) continue;
      ++followed;
      CHECK(std::abs(way->distance - d) <= rounding);
      double length = 0;
      for (const WayLeg& leg : way->legs) {
        length += distance(position_of(part.mesh(), {leg.face, leg.start, kNone}),
                           position_of(part.mesh(), {leg.face, leg.end, kNone}));
      }
      CHECK(std::abs(length - d) <= rounding);
      const auto path = trace_path(adjacency, automatic, target, Cancel());
      REQUIRE((path && *path));
      CHECK((*path)->length <= d + rounding);
      fixtures::check_is_a_path(adjacency, **path,
                                norm(part.mesh().box().max - part.mesh().box().min));
    }
  }
  MESSAGE(points << " points, known " << known << ", followed " << followed);
  CHECK(parts >= 20);
  CHECK(10 * known >= 9 * points);
  CHECK(10 * followed >= 6 * points);  // of spoiled parts, too
}

// Edges of the boundary are cut in half where they are long: there a vertex was added.
TEST_CASE("PointsAtVerticesThatWereAddedHaveTheirDistance") {
  const std::uint32_t seed = fixtures::test_seed();
  int points = 0;
  for (std::uint32_t number = 0; number < 60; ++number) {
    CAPTURE(number);
    std::mt19937 random(seed + 3000 + number);
    const Surface part(turned_part(random, number % 2 == 0 ? Spoiled::holes : Spoiled::open));
    const Adjacency& adjacency = part.adjacency();
    const std::uint32_t v = random() % part.mesh().vertex_count();
    const std::vector<Source> sources{{point_at_vertex(adjacency, v), 0}};
    const Field automatic = part.field_by(Method::back_traced, sources, {});
    if (!automatic.kept_windows || !automatic.kept_windows->is_refined) continue;
    const Field exact = part.field_by(Method::exact, sources, {});
    const PointArrivals exactly(adjacency, exact);
    const PointArrivals automatically(adjacency, automatic);
    for (std::uint32_t f = 0; f < part.mesh().face_count(); ++f) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        if (adjacency.ring(halfedge(f, c)) != halfedge(f, c)) continue;
        std::array<double, 3> weights{0.5, 0.5, 0.5};
        weights[previous_corner(c)] = 0;
        const SurfacePoint middle = point_on_face(adjacency, f, weights);
        const double d = exactly.distance_at(middle);
        const auto told = automatically.by_kept_windows(middle);
        REQUIRE(told);
        ++points;
        CHECK((d == kUnreached ? *told == d : std::abs(*told - d) <= 1e-6 * d));
      }
    }
  }
  CHECK(points >= 100);
}

TEST_CASE("SurfacesWithoutNeedlesAreNotRefined") {
  CHECK(Surface(shapes::icosphere(4)).adjacency().refined() == nullptr);
  CHECK(Surface(shapes::terrain(30, 4, 1)).adjacency().refined() == nullptr);
  // A face has nothing to be refined for, and no face even less.
  CHECK(Surface({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}).adjacency().refined() == nullptr);
}

TEST_CASE("RefiningEndsWhenItIsCancelled") {
  std::mt19937 random(fixtures::test_seed());
  const Surface part(turned_part(random, Spoiled::not_at_all, 500, 2));
  REQUIRE(part.adjacency().refined() != nullptr);
  const Triangulation mesh = part.adjacency().triangulation();
  const Cancel at_once([] { return true; });
  const auto refined = RefinedSurface::build(mesh, mesh, part.mesh().positions(), at_once);
  REQUIRE(!refined);
  CHECK(refined.error().code == ErrorCode::cancelled);
}
