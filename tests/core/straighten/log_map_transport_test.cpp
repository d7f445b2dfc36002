#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/straighten/log_map.h"
#include "core/straighten/straightest_geodesic.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/straightest.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::size_of;
using fixtures::Surface;
using fixtures::test_seed;
using std::numbers::pi;

namespace {

constexpr std::array<shapes::Hole, 2> kHoles{{{4, 5, 6}, {14, 12, 5}}};
constexpr double kFarAway = std::numeric_limits<double>::infinity();

LogMap carry(const Surface& surface, const SurfacePoint& from, Method method, double angle,
             double radius = kFarAway) {
  const Field field = surface.field_by(method, {{from, 0}});
  auto map = log_map(surface.adjacency(), field, from, radius, Cancel(), angle);
  REQUIRE(map.has_value());
  REQUIRE(map->directions.size() == map->entries.size());
  return std::move(*map);
}

SurfacePoint at_vertex(const Surface& surface, std::uint32_t vertex) {
  return point_at_vertex(surface.adjacency(), vertex);
}

SurfacePoint in_face(const Surface& surface, std::uint32_t face, std::array<double, 3> bary) {
  return point_on_face(surface.adjacency(), face, bary);
}

Vec3 place(const Surface& surface, std::uint32_t vertex) {
  return surface.mesh().positions()[vertex];
}

Vec3 unit_of(Vec3 v) { return (1 / norm(v)) * v; }

// From a to b, counter-clockwise as seen from where `seen_from` points to.
double angle_from(Vec3 a, Vec3 b, Vec3 seen_from) {
  const Vec3 normal = cross(a, b);
  return std::atan2(dot(normal, seen_from) < 0 ? -norm(normal) : norm(normal), dot(a, b));
}

bool is_same_turn(double a, double b, double within) {
  return std::abs(std::remainder(a - b, 2 * pi)) < within;
}

double some_unit(std::mt19937& random) { return random() / 4294967296.0; }

// The direction of an angle at a point inside a face, by the corners of the face alone.
Vec3 direction_in_face(const Surface& surface, std::uint32_t face, double angle) {
  const auto& corners = surface.mesh().faces()[face];
  const Vec3 along = unit_of(place(surface, corners[1]) - place(surface, corners[0]));
  const Vec3 other = place(surface, corners[2]) - place(surface, corners[0]);
  const Vec3 inward = unit_of(other - dot(other, along) * along);
  return std::cos(angle) * along + std::sin(angle) * inward;
}

// Laid over the edge that two faces have in common, by the corners alone; none if they have none.
std::optional<Vec3> turned_over(const Surface& surface, std::uint32_t before, std::uint32_t behind,
                                Vec3 direction) {
  if (before == behind) return direction;
  const auto apex_of = [&](std::uint32_t face,
                           std::uint32_t other) -> std::optional<std::uint32_t> {
    std::optional<std::uint32_t> apex;
    for (const std::uint32_t v : surface.mesh().faces()[face]) {
      const auto& corners = surface.mesh().faces()[other];
      if (std::find(corners.begin(), corners.end(), v) != corners.end()) continue;
      if (apex) return std::nullopt;
      apex = v;
    }
    return apex;
  };
  const auto a = apex_of(before, behind);
  const auto b = apex_of(behind, before);
  if (!a || !b) return std::nullopt;
  std::array<Vec3, 2> ends;
  std::size_t found = 0;
  for (const std::uint32_t v : surface.mesh().faces()[before]) {
    if (v != *a) ends[found++] = place(surface, v);
  }
  const Vec3 edge = unit_of(ends[1] - ends[0]);
  const auto away = [&](std::uint32_t apex) {
    const Vec3 to = place(surface, apex) - ends[0];
    return unit_of(to - dot(to, edge) * edge);
  };
  return dot(direction, edge) * edge - dot(direction, away(*a)) * away(*b);
}

}  // namespace

// Also behind corners of the outline, and where faces are wound this way and that.
TEST_CASE("InThePlaneACarriedDirectionIsTheSameEverywhere") {
  std::mt19937 random(test_seed());
  for (std::uint32_t kind = 0; kind < 24; ++kind) {
    CAPTURE(kind);
    TriangleSoup soup =
        kind % 2 == 0 ? shapes::plane(9, 7) : shapes::plane_with_holes(24, 24, kHoles);
    for (Vec3& p : soup.positions) {
      p.x += 0.3 * some_unit(random);
      p.y += 0.3 * some_unit(random);
    }
    const auto reverse = [&](Triangle& face) {
      if (random() % 3 == 0) std::swap(face[1], face[2]);
    };
    if (kind % 4 >= 2) std::for_each(soup.faces.begin(), soup.faces.end(), reverse);
    const Surface surface(soup);
    const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    const double a = 0.1 + 0.8 * some_unit(random);
    const SurfacePoint from =
        kind % 3 == 0 ? at_vertex(surface, surface.mesh().faces()[f][0])
                      : in_face(surface, f,
                                kind % 3 == 1 ? std::array<double, 3>{a / 2, 1 - a, a / 2}
                                              : std::array<double, 3>{a, 1 - a, 0});
    // At a vertex of the boundary, between the edges there.
    const double angle = kind % 3 == 0 ? 0 : 6 * some_unit(random);
    const LogMap map = carry(surface, from, Method::exact, angle);
    Vec3 there{};
    if (kind % 3 == 0) {
      const auto going =
          straightest_geodesic_at_angle(surface.adjacency(), from, angle, 0, Cancel());
      REQUIRE(going.has_value());
      there = going->direction_at_end;
    } else {
      there = direction_in_face(surface, from.face, angle);
    }
    for (std::size_t i = 0; i < map.entries.size(); ++i) {
      CAPTURE(map.entries[i].vertex);
      // A path that is longer by 1e-12 where it bends at a vertex sets out some 1e-6 beside.
      CHECK(norm(map.directions[i] - there) < (map.entries[i].is_straight ? 1e-7 : 1e-4));
    }
  }
}

// A cylinder unrolls: along the axis and along its facets nothing changes.
TEST_CASE("RoundACylinderACarriedDirectionTurnsWithTheFacets") {
  std::mt19937 random(test_seed());
  constexpr std::uint32_t kSides = 16;
  constexpr std::uint32_t kRings = 12;
  TriangleSoup soup;
  for (std::uint32_t r = 0; r < kRings; ++r) {
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const double u = 2 * pi * s / kSides;
      soup.positions.push_back({std::cos(u), std::sin(u), 0.3 * r});
      if (r == 0) continue;
      const std::uint32_t a = (r - 1) * kSides + s;
      const std::uint32_t b = (r - 1) * kSides + (s + 1) % kSides;
      soup.faces.push_back({a, b, a + kSides});
      soup.faces.push_back({b, b + kSides, a + kSides});
    }
  }
  const Surface surface(soup);
  for (int i = 0; i < 8; ++i) {
    const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    const double angle = 2 * pi * some_unit(random);
    const SurfacePoint from = in_face(surface, f, {0.3, 0.4, 0.3});
    const LogMap map = carry(surface, from, Method::exact, angle);
    const Vec3 set_out = direction_in_face(surface, f, angle);
    const Vec3 middle = position_of(surface.mesh(), from);
    const double facet = std::floor(std::atan2(middle.y, middle.x) / (2 * pi) * kSides) + 0.5;
    const auto round_of = [&](double number) {
      const double u = 2 * pi * number / kSides;
      return Vec3{-std::sin(u), std::cos(u), 0};
    };
    const double round = dot(set_out, round_of(facet));
    for (std::size_t k = 0; k < map.entries.size(); ++k) {
      const Vec3 at = place(surface, map.entries[k].vertex);
      const Vec3 direction = map.directions[k];
      CHECK(norm(direction) == doctest::Approx(1));
      CHECK(direction.z == doctest::Approx(set_out.z).epsilon(1e-6));
      const double corner = std::atan2(at.y, at.x) / (2 * pi) * kSides;
      const Vec3 on_one = round * round_of(std::round(corner) - 0.5);
      const Vec3 on_other = round * round_of(std::round(corner) + 0.5);
      const Vec3 flat{direction.x, direction.y, 0};
      CHECK(std::min(norm(flat - on_one), norm(flat - on_other)) < 1e-6);
    }
  }
}

// On an unrolled cone it stays as it is, so to the line to the apex it turns by the angle between
// the two lines there. Once round the apex, by what both ways round come to: all but the deficit.
TEST_CASE("RoundAConeACarriedDirectionTurnsByTheAngleAtTheApex") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 10; ++i) {
    const auto sides = static_cast<std::uint32_t>(5 + random() % 20);
    const double total = (0.3 + 1.6 * some_unit(random)) * pi;  // at the apex
    const double base = std::sin(total / sides / 2) / std::sin(pi / sides);
    TriangleSoup soup;
    soup.positions.push_back({0, 0, std::sqrt(1 - base * base)});
    for (std::uint32_t k = 0; k < sides; ++k) {
      const double u = 2 * pi * k / sides;
      soup.positions.push_back({base * std::cos(u), base * std::sin(u), 0});
      soup.faces.push_back({0, 1 + k, 1 + (k + 1) % sides});
    }
    // Below the rim a second ring, farther down the same cone.
    for (std::uint32_t k = 0; k < sides; ++k) {
      soup.positions.push_back(2 * soup.positions[1 + k] - soup.positions[0]);
      const std::uint32_t next = (k + 1) % sides;
      soup.faces.push_back({1 + k, 1 + sides + k, 1 + sides + next});
      soup.faces.push_back({1 + k, 1 + sides + next, 1 + next});
    }
    const Surface surface(soup);
    const auto to_apex = [&](Vec3 at) { return unit_of(soup.positions[0] - at); };
    const auto outward = [](Vec3 at) { return Vec3{at.x, at.y, 0}; };
    std::uint32_t source = 0;  // that of the first of the inner ring
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      if (norm(place(surface, v) - soup.positions[1]) < 1e-9) source = v;
    }
    const SurfacePoint from = at_vertex(surface, source);
    const double angle = 6 * some_unit(random);
    const LogMap map = carry(surface, from, Method::exact, angle);
    const auto here = std::find_if(map.entries.begin(), map.entries.end(),
                                   [&](const auto& e) { return e.vertex == source; });
    const Vec3 start = soup.positions[1];
    const double set_out = angle_from(
        to_apex(start), map.directions[static_cast<std::size_t>(here - map.entries.begin())],
        outward(start));
    for (std::size_t k = 0; k < map.entries.size(); ++k) {
      const Vec3 at = place(surface, map.entries[k].vertex);
      if (norm(outward(at)) < 1e-9) continue;
      double turn = std::atan2(at.y, at.x);                // of the cone's own, from the source
      if (std::abs(std::abs(turn) - pi) < 1e-6) continue;  // two paths are as long
      turn *= total / (2 * pi);
      const double found = angle_from(to_apex(at), map.directions[k], outward(at));
      CAPTURE(turn);
      CHECK(is_same_turn(found, set_out - turn, 1e-5));
    }
  }
}

// Along a great circle a direction keeps its angle to the circle: it turns with the sphere.
TEST_CASE("OnASphereACarriedDirectionTurnsWithTheGreatCircle") {
  std::mt19937 random(test_seed());
  const Surface surface(shapes::icosphere(5));
  const auto source = static_cast<std::uint32_t>(random() % surface.mesh().vertex_count());
  const SurfacePoint from = at_vertex(surface, source);
  const LogMap map = carry(surface, from, Method::back_traced, 6 * some_unit(random), 2.0);
  const Vec3 pole = unit_of(place(surface, source));
  Vec3 start{};
  for (std::size_t i = 0; i < map.entries.size(); ++i) {
    if (map.entries[i].vertex == source) start = map.directions[i];
  }
  REQUIRE(norm(start) == doctest::Approx(1));
  start = unit_of(start - dot(start, pole) * pole);
  for (std::size_t i = 0; i < map.entries.size(); ++i) {
    const Vec3 at = unit_of(place(surface, map.entries[i].vertex));
    if (map.entries[i].vertex == source) continue;
    const Vec3 axis = unit_of(cross(pole, at));
    const Vec3 leaves = cross(axis, pole);
    const Vec3 arrives = cross(axis, at);
    const Vec3 expected = dot(start, axis) * axis + dot(start, leaves) * arrives;
    CHECK(norm(map.directions[i] - expected) < 0.1);
  }
}

// Face by face along the line straight ahead, laid over one edge after the other in space.
TEST_CASE("OnAnySurfaceADirectionIsCarriedOverOneEdgeAfterTheOther") {
  std::mt19937 random(test_seed());
  std::size_t compared = 0;
  for (std::uint32_t i = 0; i < 40; ++i) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    const SurfacePoint from = in_face(surface, f, {0.3, 0.4, 0.3});
    const double angle = 6 * some_unit(random);
    const Field field = surface.field_by(Method::exact, {{from, 0}});
    const auto map = log_map(surface.adjacency(), field, from, kFarAway, Cancel(), angle);
    REQUIRE(map.has_value());
    for (std::size_t k = 0; k < map->entries.size(); ++k) {
      const LogMap::Entry& entry = map->entries[k];
      const double length = norm(map->directions[k]);
      CHECK((length == 0 || std::abs(length - 1) < 1e-9));
      if (!entry.is_straight || length == 0) continue;
      const auto line = straightest_geodesic_at_angle(surface.adjacency(), from, entry.angle,
                                                      entry.distance, Cancel());
      REQUIRE(line.has_value());
      const auto& points = line->path.points;
      std::optional<Vec3> direction = direction_in_face(surface, f, angle);
      std::uint32_t face = f;
      for (std::size_t p = 0; p + 1 < points.size() && direction; ++p) {
        if (points[p].point.at_vertex()) direction.reset();  // within rounding of it
        if (direction) direction = turned_over(surface, face, points[p].point.face, *direction);
        face = points[p].point.face;
      }
      // Past the vertex by rounding, it may come to an end in a face beside.
      const auto& corners = surface.mesh().faces()[face];
      if (!direction || points.size() < 2 ||
          std::find(corners.begin(), corners.end(), entry.vertex) == corners.end() ||
          distance(points[points.size() - 2].position, points.back().position) <
              1e-3 * size_of(surface)) {
        continue;
      }
      CAPTURE(entry.vertex);
      CHECK(norm(*direction - map->directions[k]) < 1e-6);
      ++compared;
    }
  }
  CHECK(compared > 200);
}

// Twelve faces of 40 degrees about a vertex: a full turn there is 480 degrees, of which each face
// is a twelfth.
TEST_CASE("PastAVertexADirectionKeepsItsShareOfATurn") {
  constexpr std::uint32_t kSides = 12;
  const double side = 40 * pi / 180;
  const double c = std::sqrt((1 + std::cos(side)) / (1 + std::cos(2 * pi / kSides)));
  const double h = std::sqrt(1 - c * c);
  TriangleSoup soup;
  soup.positions.push_back({0, 0, 0});
  for (std::uint32_t k = 0; k < kSides; ++k) {
    const double u = 2 * pi * k / kSides;
    soup.positions.push_back({c * std::cos(u), c * std::sin(u), k % 2 == 0 ? h : -h});
    soup.faces.push_back({0, 1 + k, 1 + (k + 1) % kSides});
  }
  const Surface surface(soup);
  std::vector<std::uint32_t> rim(kSides);
  std::uint32_t middle = 0;
  for (std::uint32_t v = 0; v <= kSides; ++v) {
    const Vec3 p = place(surface, v);
    if (norm(p) < 0.5) {
      middle = v;
    } else {
      rim[static_cast<std::uint32_t>(std::lround(std::atan2(p.y, p.x) * kSides / (2 * pi)) +
                                     kSides) %
          kSides] = v;
    }
  }
  const Vec3 up{0, 0, 1};
  std::size_t passed = 0;
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const LogMap map = carry(surface, at_vertex(surface, rim[i]), Method::exact, 0.3);
    const auto direction_at = [&](std::uint32_t v) {
      for (std::size_t k = 0; k < map.entries.size(); ++k) {
        if (map.entries[k].vertex == v) return map.directions[k];
      }
      return Vec3{};
    };
    const Vec3 to_middle = -1 * place(surface, rim[i]);
    const double came = angle_from(to_middle, direction_at(middle), up);
    for (std::uint32_t turn = 5; turn <= 7; ++turn) {  // of 40 degrees: 200 and more to either side
      const std::uint32_t v = rim[(i + turn) % kSides];
      const double went = angle_from(place(surface, v), direction_at(v), up);
      CHECK(is_same_turn(went, came - (2 * pi * turn / kSides - pi), 1e-6));
      ++passed;
    }
  }
  CHECK(passed == 3 * kSides);
}

TEST_CASE("PastAPinchedVertexNoDirectionIsCarried") {
  TriangleSoup bow;  // two faces that meet in a vertex alone
  bow.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  bow.faces = {{0, 1, 2}, {0, 3, 4}};
  const Surface surface(bow);
  const SurfacePoint from = in_face(surface, 0, {0.2, 0.3, 0.5});
  const LogMap map = carry(surface, from, Method::exact, 0);
  REQUIRE(map.entries.size() == 5);
  for (std::size_t k = 0; k < 5; ++k) {
    const Vec3 at = place(surface, map.entries[k].vertex);
    const bool is_beyond = dot(at, position_of(surface.mesh(), from)) < 0;
    CHECK(norm(map.directions[k]) == doctest::Approx(is_beyond ? 0 : 1));
  }
}

TEST_CASE("ADirectionIsCarriedByTheSameAngleWithinTurnsOfIt") {
  const Surface surface(shapes::icosphere(3));
  const LogMap one = carry(surface, at_vertex(surface, 5), Method::exact, 0.4, 1.0);
  const LogMap other =
      carry(surface, at_vertex(surface, 5), Method::exact, 0.4 + one.total_angle, 1.0);
  for (std::size_t k = 0; k < one.entries.size(); ++k) {
    CHECK(norm(one.directions[k] - other.directions[k]) < 1e-9);
  }
}

TEST_CASE("CarryingIsStoppedInTheMiddle") {
  const Surface surface(shapes::icosphere(4));
  const SurfacePoint from = at_vertex(surface, 3);
  const Field field = surface.field_by(Method::exact, {{from, 0}});
  std::size_t asked = 0;
  const Cancel counting([&] { return ++asked > 20; });
  const auto map = log_map(surface.adjacency(), field, from, kFarAway, counting, 0.0);
  REQUIRE_FALSE(map.has_value());
  CHECK(map.error().code == ErrorCode::cancelled);
}
