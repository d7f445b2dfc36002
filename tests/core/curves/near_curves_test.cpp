// Near a curve by approximate methods: points in the faces beside it, paths that leave it, and
// vertices that its strips do not reach.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "tests/core/curves/curve_fixtures.h"
#include "tests/fixtures/random_meshes.h"

using namespace geodesic;
using fixtures::ask_some_lines;
using fixtures::LineQuestion;
using fixtures::RandomMesh;
using fixtures::some_point;
using fixtures::Surface;
using fixtures::test_seed;
using fixtures::to_polyline;

namespace {

constexpr std::array kAll{Method::wavefront,     Method::novotni,     Method::dijkstra,
                          Method::fast_marching, Method::back_traced, Method::steiner,
                          Method::chen_han,      Method::exact};

// Few and large faces, where corners are far from what is between them.
Surface coarse_plane(std::mt19937& random) {
  TriangleSoup soup = shapes::plane(2 + random() % 4, 2 + random() % 4);
  const double slant = random() / 4294967296.0;
  for (Vec3& p : soup.positions) p = {p.x + slant * p.y, p.y, 0.5 * p.y - p.x};
  return Surface(soup);
}

// A point in the face, well inside.
SurfacePoint inside(const Surface& surface, std::uint32_t face, std::mt19937& random) {
  const auto unit = [&] { return 0.02 + random() / 4294967296.0; };
  return point_on_face(surface.adjacency(), face, {unit(), unit(), unit()});
}

// Whether the straight line between two points of a plane crosses a side of a face.
bool crosses(const Surface& surface, Halfedge side, const SurfacePoint& from,
             const SurfacePoint& to) {
  const std::span<const Vec3> at = surface.mesh().positions();
  const Vec3 tail = at[surface.adjacency().tail(side)];
  const Vec3 along = at[surface.adjacency().head(side)] - tail;
  const auto part_and_height = [&](const SurfacePoint& point) {
    const Vec3 there = position_of(surface.mesh(), point) - tail;
    const double part = dot(there, along) / dot(along, along);
    return std::pair(part, norm(there - part * along));
  };
  const auto [part, height] = part_and_height(from);
  const auto [other_part, other_height] = part_and_height(to);
  const double crossing = (part * other_height + other_part * height) / (height + other_height);
  return crossing > 1e-6 && crossing < 1 - 1e-6;
}

}  // namespace

// In a plane: where the straight line from the end of a curve stays in its face and the next one.
TEST_CASE("APointBesideTheEndOfACurveIsNoFartherThanStraight") {
  std::mt19937 random(test_seed() + 1);
  int found_straight = 0;
  for (int round = 0; round < 400; ++round) {
    CAPTURE(round);
    const Surface surface = coarse_plane(random);
    const Halfedge side =
        halfedge(static_cast<std::uint32_t>(random() % surface.mesh().face_count()), random() % 3);
    const Halfedge beyond = surface.adjacency().ring(side);
    const SurfacePoint end = inside(surface, face_of(side), random);
    const SurfacePoint beside = inside(surface, face_of(beyond), random);
    if (beyond == side || !crosses(surface, side, end, beside)) continue;
    ++found_straight;
    LineQuestion question(surface);
    (void)question.curve({some_point(surface, random), end}, false);
    const double straight =
        distance(position_of(surface.mesh(), end), position_of(surface.mesh(), beside));
    for (const Method method : {Method::wavefront, Method::novotni, Method::exact}) {
      CAPTURE(int(method));
      const Field field = question.field(method);
      const double found = question.at(field, beside);
      CHECK(found <= straight * (1 + 1e-9));
      const auto path = question.path(field, beside);
      REQUIRE(path);
      if (method == Method::exact) CHECK(path->length <= found * (1 + 1e-9));
    }
  }
  CHECK(found_straight > 100);
}

// With both ends given, the shortest path in a convex plane is a straight line. Where it begins it
// is at a right angle to the curve, or at one of its corners.
TEST_CASE("RefinedPathsFromACurveInAPlaneAreStraight") {
  std::mt19937 random(test_seed() + 2);
  for (int round = 0; round < 100; ++round) {
    CAPTURE(round);
    const Surface surface = coarse_plane(random);
    const Mesh& mesh = surface.mesh();
    const std::vector<SurfacePoint> corners{some_point(surface, random),
                                            some_point(surface, random)};
    LineQuestion question(surface);
    (void)question.curve(corners, false);
    const SurfacePoint target = some_point(surface, random);
    const std::vector<Vec3> line{position_of(mesh, corners[0]), position_of(mesh, corners[1])};
    const double extent = norm(mesh.box().max - mesh.box().min);
    const double least = to_polyline(position_of(mesh, target), line, false);
    for (const Method method : kAll) {
      CAPTURE(int(method));
      const Field field = question.field(method);
      const auto traced = question.path(field, target);
      const auto path = question.path(field, target, PathWork::refined);
      REQUIRE(path);
      const Vec3 start = path->points.front().position;
      CHECK(path->length <= distance(start, path->points.back().position) + 1e-9 * extent);
      CHECK(to_polyline(start, line, false) < 1e-9 * extent);
      CHECK(path->length >= least - 1e-9 * extent);
      CHECK(path->length <= traced->length + 1e-9 * extent);
      CHECK(distance(path->points.back().position, position_of(mesh, target)) < 1e-9 * extent);
    }
  }
}

// Distances along a graph are a metric, whatever they start from.
TEST_CASE("FromLinesNoVertexIsFartherThanByWayOfItsNeighbour") {
  std::mt19937 random(test_seed() + 3);
  for (int round = 0; round < 100; ++round) {
    CAPTURE(round);
    RandomMesh mesh(random());
    const Surface surface(mesh.soup());
    LineQuestion question(surface);
    ask_some_lines(surface, random, question);
    const std::span<const Vec3> at = surface.mesh().positions();
    const double rounding = 1e-12 * norm(surface.mesh().box().max - surface.mesh().box().min);
    for (const Method method : {Method::dijkstra, Method::steiner}) {
      CAPTURE(int(method));
      const Field field = question.field(method);
      for (const Triangle& face : surface.mesh().faces()) {
        for (std::size_t c = 0; c < 3; ++c) {
          const std::uint32_t a = face[c];
          const std::uint32_t b = face[(c + 1) % 3];
          if (field.distance[a] == kUnreached || field.distance[b] == kUnreached) continue;
          CHECK(field.distance[a] <= field.distance[b] + distance(at[a], at[b]) + rounding);
          CHECK(field.distance[b] <= field.distance[a] + distance(at[a], at[b]) + rounding);
        }
      }
    }
  }
}
