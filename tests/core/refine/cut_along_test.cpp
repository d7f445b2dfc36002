#include "core/refine/cut_along.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/memory_budget.h"
#include "core/locate/closest_point.h"
#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "core/refine/faces_inside.h"
#include "core/solve/distance_at_point.h"
#include "core/solve/pair_search.h"
#include "tests/core/refine/cut_surface.h"
#include "tests/core/refine/lines_on_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/tube.h"
#include "tests/fixtures/uneven_planes.h"

using namespace geodesic;
using fixtures::Cut;
using fixtures::kPlenty;
using fixtures::length_of;
using fixtures::random_line;
using fixtures::random_point;
using fixtures::RandomMesh;
using fixtures::straight;
using fixtures::Surface;
using fixtures::test_seed;
using fixtures::uneven_plane;

namespace {

double turn(Vec3 a, Vec3 b, Vec3 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

struct Wall {
  Vec3 a;
  Vec3 b;
  [[nodiscard]] bool stops(Vec3 p, Vec3 q) const {
    constexpr double kTouch = 1e-9;
    const double side_p = turn(a, b, p);
    const double side_q = turn(a, b, q);
    const double side_a = turn(p, q, a);
    const double side_b = turn(p, q, b);
    return std::min(side_p, side_q) < -kTouch && std::max(side_p, side_q) > kTouch &&
           std::min(side_a, side_b) < -kTouch && std::max(side_a, side_b) > kTouch;
  }
};

// Up to three straight walls on a plane, as lines there and in space.
std::pair<std::vector<SurfacePolyline>, std::vector<Wall>> random_walls(RandomMesh& random,
                                                                        const Surface& plane) {
  std::vector<SurfacePolyline> lines;
  std::vector<Wall> walls;
  for (std::uint32_t k = 0; k <= random.below(3); ++k) {
    const SurfacePoint a = random_point(random, plane);
    const SurfacePoint b = random_point(random, plane);
    SurfacePolyline line = straight(plane, a, b);
    const Wall wall{position_of(plane.mesh(), a), position_of(plane.mesh(), b)};
    // From one copy of a face to another the way leads to its border and back.
    if (length_of(plane.mesh(), line) > distance(wall.a, wall.b) + 1e-9) continue;
    lines.push_back(std::move(line));
    walls.push_back(wall);
  }
  return {std::move(lines), std::move(walls)};
}

// The shortest way from the first corner to the last, straight from corner to corner where no wall
// is between them: by a graph of which corners see each other.
double way_round(const std::vector<Wall>& walls, Vec3 from, Vec3 to) {
  std::vector<Vec3> corners{from};
  for (const Wall& wall : walls) {
    corners.push_back(wall.a);
    corners.push_back(wall.b);
  }
  corners.push_back(to);
  std::vector<double> length(corners.size(), kUnreached);
  length[0] = 0;
  for (std::size_t round = 0; round < corners.size(); ++round) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (std::size_t k = 0; k < corners.size(); ++k) {
        const bool is_open = std::none_of(walls.begin(), walls.end(), [&](const Wall& wall) {
          return wall.stops(corners[i], corners[k]);
        });
        if (is_open) length[k] = std::min(length[k], length[i] + distance(corners[i], corners[k]));
      }
    }
  }
  return length.back();
}

// Crossed walls may have closed the way.
bool is_as_far(double found, double expected) {
  return found == expected || std::abs(found - expected) < 1e-8;
}

}  // namespace

TEST_CASE("WaysGoRoundTheEndsOfWallsOnAPlane") {
  for (std::uint32_t i = 0; i < 20; ++i) {
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    const Surface plane(uneven_plane(random, 5 + random.below(4)));
    const auto [lines, walls] = random_walls(random, plane);
    const Cut cut(plane, lines);
    CHECK(cut.cut.mesh.area() == doctest::Approx(plane.mesh().area()).epsilon(1e-12));
    const std::uint32_t face = random.below(plane.mesh().source_face_count());
    const Weights bary{0.2 + random.unit(), 0.2 + random.unit(), 0.2 + random.unit()};
    const SurfacePoint from = cut.on(face, plane.on(face, bary).bary);
    const Vec3 start = position_of(cut.cut.mesh, from);
    CHECK(distance(start, position_of(plane.mesh(), plane.on(face, bary))) < 1e-9);
    const Field field = cut.field(from);
    for (std::uint32_t s = 0; s < plane.mesh().source_vertex_count(); ++s) {
      const std::uint32_t v = cut.cut.mesh.vertex_of_source()[s];
      const Vec3 end = cut.cut.mesh.positions()[v];
      CHECK(is_as_far(field.distance[v], way_round(walls, start, end)));
    }
    const PointArrivals arrivals(*cut.adjacency, field);
    for (int k = 0; k < 20; ++k) {
      const std::uint32_t at = random.below(plane.mesh().source_face_count());
      const SurfacePoint there = plane.on(at, {random.unit(), random.unit(), random.unit()});
      const SurfacePoint to = cut.on(at, there.bary);
      const auto found = distance_at_point(*cut.adjacency, field, arrivals, to, Cancel());
      REQUIRE(found);
      CHECK(is_as_far(*found, way_round(walls, start, position_of(plane.mesh(), there))));
    }
  }
}

// Once for each side, as many programs write it: what stops a way on one stops it on all.
TEST_CASE("WallsHoldWhereFacesAreThereSeveralTimes") {
  for (std::uint32_t i = 0; i < 15; ++i) {
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    TriangleSoup soup = uneven_plane(random, 5 + random.below(4));
    const auto once = static_cast<std::uint32_t>(soup.faces.size());
    const bool is_all = random.below(2) == 0;
    for (std::uint32_t f = 0; f < once; ++f) {
      if (!is_all && random.below(3) == 0) continue;
      Triangle copy = soup.faces[f];
      if (random.below(2) == 0) std::swap(copy[0], copy[1]);
      std::rotate(copy.begin(), copy.begin() + random.below(3), copy.end());
      soup.faces.push_back(copy);
    }
    // The copies may come before what they are copies of.
    if (random.below(2) == 0) std::reverse(soup.faces.begin(), soup.faces.end());
    const Surface plane(soup);
    const auto [lines, walls] = random_walls(random, plane);
    const Cut cut(plane, lines);
    CHECK(cut.cut.mesh.area() == doctest::Approx(plane.mesh().area()).epsilon(1e-12));
    for (const FacePiece& piece : cut.cut.refinement.pieces()) {
      const auto& [a, b, c] = piece.corners;
      CHECK((b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]) >= -1e-15);
    }
    const std::uint32_t face = random.below(plane.mesh().source_face_count());
    const Weights bary{0.2 + random.unit(), 0.2 + random.unit(), 0.2 + random.unit()};
    const SurfacePoint from = cut.on(face, plane.on(face, bary).bary);
    const Vec3 start = position_of(cut.cut.mesh, from);
    CHECK(distance(start, position_of(plane.mesh(), plane.on(face, bary))) < 1e-9);
    const Field field = cut.field(from);
    for (std::uint32_t s = 0; s < plane.mesh().source_vertex_count(); ++s) {
      const std::uint32_t v = cut.cut.mesh.vertex_of_source()[s];
      const double expected = way_round(walls, start, cut.cut.mesh.positions()[v]);
      CHECK(is_as_far(field.distance[v], expected));
    }
  }
}

TEST_CASE("ATubeThatIsCutAlongIsAStrip") {
  for (std::uint32_t i = 0; i < 10; ++i) {
    RandomMesh random(test_seed() + i);
    const std::uint32_t n = 5 + random.below(20);
    const double height = 0.2 + 3 * random.unit();
    const Surface tube(fixtures::tube(n, height));
    const double u = 0.05 + 0.9 * random.unit();
    const std::uint32_t side = random.below(n);
    const SurfacePolyline line{tube.on(2 * side, {1 - u, u, 0}), tube.on(2 * side, {1 - u, 0, u}),
                               tube.on(2 * side + 1, {0, u, 1 - u})};
    const Cut cut(tube, {line});
    const double width = 2 * std::sin(std::numbers::pi / n);
    // How far round from the wall.
    const auto round = [&](std::uint32_t s) {
      return width * ((s % n + n - side - 1) % n + 1 - u);
    };
    const std::uint32_t from = random.below(2 * n);
    const auto vertices = cut.cut.mesh.vertex_of_source();
    const Field field = cut.field(point_at_vertex(*cut.adjacency, vertices[from]));
    for (std::uint32_t s = 0; s < 2 * n; ++s) {
      const double up = s / n == from / n ? 0 : height;
      CHECK(field.distance[vertices[s]] ==
            doctest::Approx(std::hypot(round(s) - round(from), up)).epsilon(1e-9));
    }
  }
}

TEST_CASE("WhatIsInsideAWallIsNotReachedAndHasTheAreaOfItsPolygon") {
  for (std::uint32_t i = 0; i < 15; ++i) {
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    const Surface plane(uneven_plane(random, 9));
    // Corners round a middle are those of a simple polygon.
    const std::uint32_t corners = 3 + random.below(4);
    SurfacePolyline line;
    std::vector<Vec3> polygon;
    std::vector<SurfacePoint> points;
    const auto index = ClosestPointIndex::build(plane.shared(), Cancel());
    REQUIRE(index);
    for (std::uint32_t c = 0; c < corners; ++c) {
      const double angle = 2 * std::numbers::pi * (c + 0.6 * random.unit()) / corners;
      const double radius = 1 + 1.6 * random.unit();
      const auto found = (*index)->closest(
          {4 + radius * std::cos(angle), 4 + radius * std::sin(angle), 0}, Cancel());
      REQUIRE(found);
      points.push_back(found->point);
      polygon.push_back(position_of(plane.mesh(), found->point));
    }
    for (std::uint32_t c = 0; c < corners; ++c) {
      for (const SurfacePoint& point : straight(plane, points[c], points[(c + 1) % corners])) {
        line.push_back(point);
      }
    }
    double area = 0;
    for (std::uint32_t c = 0; c < corners; ++c) {
      area += 0.5 * turn({4, 4, 0}, polygon[c], polygon[(c + 1) % corners]);
    }
    const Cut cut(plane, {line});
    const Adjacency refined = Adjacency::build(std::make_shared<const Mesh>(cut.refined.mesh));
    const auto inside = faces_inside(refined, cut.refined.chains[0], Cancel());
    REQUIRE(inside);
    double found_area = 0;
    for (std::uint32_t f = 0; f < refined.mesh().face_count(); ++f) {
      const Triangle& t = refined.mesh().faces()[f];
      const auto p = refined.mesh().positions();
      if ((*inside)[f] != 0) found_area += 0.5 * std::abs(turn(p[t[0]], p[t[1]], p[t[2]]));
    }
    CHECK(found_area == doctest::Approx(area).epsilon(1e-8));
    // What is left by itself has that area, too.
    const auto alone = cut_along(cut.refined, {}, *inside, Cancel());
    REQUIRE(alone);
    CHECK(alone->mesh.area() == doctest::Approx(area).epsilon(1e-8));
    // From a corner of the plane.
    const Field field =
        cut.field(point_at_vertex(*cut.adjacency, cut.cut.mesh.vertex_of_source()[0]));
    for (std::uint32_t s = 0; s < plane.mesh().source_vertex_count(); ++s) {
      const Vec3 p = plane.mesh().positions()[plane.vertex(s)];
      bool is_in = false;
      bool is_near = false;
      for (std::uint32_t c = 0; c < corners; ++c) {
        const Vec3 a = polygon[c];
        const Vec3 b = polygon[(c + 1) % corners];
        is_near = is_near || std::abs(turn(a, b, p)) < 1e-6;
        if ((a.y > p.y) != (b.y > p.y) && (p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x))) {
          is_in = !is_in;
        }
      }
      if (is_near) continue;
      CHECK((field.distance[cut.cut.mesh.vertex_of_source()[s]] == kUnreached) == is_in);
      const bool is_kept = alone->mesh.vertex_of_source()[s] != kNone;
      CHECK(is_kept == is_in);
    }
  }
}

TEST_CASE("AWallAlongEdgesIsAFileThatIsCutThere") {
  constexpr std::uint32_t kSide = 7;
  const TriangleSoup soup = shapes::terrain(kSide, 3, test_seed());
  const Surface surface(soup);
  // Up the fourth column, from the border to a vertex inside.
  SurfacePolyline line;
  constexpr std::uint32_t kColumn = 3;
  constexpr std::uint32_t kRows = 4;
  const auto vertex = [](std::uint32_t row, std::uint32_t column) { return row * kSide + column; };
  for (std::uint32_t row = 0; row <= kRows; ++row) line.push_back(surface.at(vertex(row, kColumn)));
  const Cut cut(surface, {line});
  // By hand: faces to the right of the column get vertices of their own.
  TriangleSoup by_hand = soup;
  for (std::uint32_t row = 0; row < kRows; ++row) {
    by_hand.positions.push_back(soup.positions[vertex(row, kColumn)]);
  }
  for (auto& face : by_hand.faces) {
    const bool is_right =
        std::any_of(face.begin(), face.end(), [](std::uint32_t v) { return v % kSide > kColumn; });
    for (std::uint32_t& v : face) {
      const std::uint32_t row = v / kSide;
      if (is_right && v % kSide == kColumn && row < kRows) v = kSide * kSide + row;
    }
  }
  const auto hand_mesh = Mesh::build(by_hand, Weld::off);
  REQUIRE(hand_mesh);
  const Adjacency hand = Adjacency::build(std::make_shared<const Mesh>(*hand_mesh));
  for (std::uint32_t from = 0; from < soup.positions.size(); from += 5) {
    SolveScratch scratch;
    const Source source{point_at_vertex(hand, hand_mesh->vertex_of_source()[from]), 0};
    const auto expected = solve_field(Method::exact, {}, hand, {&source, 1}, {}, scratch, Cancel());
    REQUIRE(expected);
    const Field found =
        cut.field(point_at_vertex(*cut.adjacency, cut.cut.mesh.vertex_of_source()[from]));
    for (std::uint32_t s = 0; s < soup.positions.size(); ++s) {
      CHECK(found.distance[cut.cut.mesh.vertex_of_source()[s]] ==
            doctest::Approx(expected->distance[hand_mesh->vertex_of_source()[s]]).epsilon(1e-12));
    }
  }
}

TEST_CASE("WallsMakeNoWayShorterAndThoseInsideNothingLonger") {
  for (std::uint32_t i = 0; i < 25; ++i) {
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    std::vector<SurfacePolyline> lines;
    for (std::uint32_t k = 0; k <= random.below(3); ++k) {
      lines.push_back(random_line(random, surface.adjacency(), 1 + random.below(10)));
    }
    const Cut cut(surface, lines);
    CHECK(cut.cut.mesh.area() == doctest::Approx(surface.mesh().area()).epsilon(1e-9));
    const std::uint32_t from = random.vertex();
    const Field before = surface.field_by(Method::exact, {Source{surface.at(from), 0}});
    const Field after =
        cut.field(point_at_vertex(*cut.adjacency, cut.cut.mesh.vertex_of_source()[from]));
    const double size = distance(surface.mesh().box().min, surface.mesh().box().max);
    bool is_open = true;  // no wall joins or divides anything: it is a point
    for (const auto& chain : cut.refined.chains) is_open = is_open && chain.size() == 1;
    for (std::uint32_t s = 0; s < surface.mesh().source_vertex_count(); ++s) {
      const std::uint32_t v = cut.cut.mesh.vertex_of_source()[s];
      const std::uint32_t w = surface.vertex(s);
      if (v == kNone) {
        CHECK(surface.adjacency().corners(w).empty());
        continue;
      }
      CHECK(cut.cut.mesh.source_of_vertex(v) == surface.mesh().source_of_vertex(w));
      CHECK(after.distance[v] >= before.distance[w] - 1e-9 * size);
      if (is_open && before.distance[w] != kUnreached) {
        CHECK(std::abs(after.distance[v] - before.distance[w]) <= 1e-9 * size);
      }
    }
  }
}

TEST_CASE("LinesThatDoNotSeparateHaveNoInside") {
  const Surface surface(shapes::torus_knot(20, 6, 0.3));
  // Once round the tube.
  const Mesh& mesh = surface.mesh();
  SurfacePolyline line;
  for (std::uint32_t k = 0; k <= 6; ++k) line.push_back(surface.at(k % 6));
  const std::vector<SurfacePolyline> lines{line};
  const auto refined = refine_along(surface.adjacency(), lines, kPlenty, Cancel());
  REQUIRE(refined);
  const Adjacency adjacency = Adjacency::build(std::make_shared<const Mesh>(refined->mesh));
  const auto inside = faces_inside(adjacency, refined->chains[0], Cancel());
  REQUIRE(!inside);
  CHECK(inside.error().code == ErrorCode::value_out_of_range);
  CHECK(mesh.face_count() == refined->mesh.face_count());
  const auto none = faces_inside(adjacency, {}, Cancel());
  CHECK(!none);
  const auto stopped = faces_inside(adjacency, refined->chains[0], Cancel([] { return true; }));
  REQUIRE(!stopped);
  CHECK(stopped.error().code == ErrorCode::cancelled);
}

TEST_CASE("CuttingCanBeStoppedAndIsRefusedWithoutFacesOrMemory") {
  RandomMesh random(test_seed());
  const Surface surface(shapes::plane(12, 12));
  const std::vector<SurfacePolyline> lines{random_line(random, surface.adjacency(), 20)};
  const auto refined = refine_along(surface.adjacency(), lines, kPlenty, Cancel());
  REQUIRE(refined);
  const std::vector<std::uint32_t> walls{0};
  const std::vector<std::uint8_t> all(refined->mesh.face_count(), 1);
  const auto stopped = cut_along(*refined, walls, all, Cancel([] { return true; }));
  REQUIRE(!stopped);
  CHECK(stopped.error().code == ErrorCode::cancelled);
  const std::vector<std::uint8_t> none(refined->mesh.face_count(), 0);
  const auto nothing = cut_along(*refined, walls, none, Cancel());
  REQUIRE(!nothing);
  CHECK(nothing.error().code == ErrorCode::no_triangles);
  // Whenever memory is refused, that is the error.
  std::uint64_t asked = 0;
  MemoryBudget counting([&](std::uint64_t) {
    ++asked;
    return std::optional<Error>();
  });
  REQUIRE(cut_along(*refined, walls, all, Cancel({}, {}, &counting)));
  for (std::uint64_t most = 0; most < asked; ++most) {
    std::uint64_t times = 0;
    MemoryBudget scant([&](std::uint64_t) {
      return ++times > most ? std::optional(Error{ErrorCode("too_much_memory"), "no", {}, {}, {}})
                            : std::nullopt;
    });
    const auto refused = cut_along(*refined, walls, all, Cancel({}, {}, &scant));
    REQUIRE(!refused);
    CHECK(refused.error().code == ErrorCode("too_much_memory"));
  }
}
