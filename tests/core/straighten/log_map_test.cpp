#include "core/straighten/log_map.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
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

constexpr double kFar = std::numeric_limits<double>::infinity();

Result<LogMap> map_of(const Surface& surface, const SurfacePoint& from, Method method,
                      double radius = kFar) {
  const Field field = surface.field_by(method, {{from, 0}});
  return log_map(surface.adjacency(), field, from, radius, Cancel());
}

Vec3 position(const Surface& surface, std::uint32_t vertex) {
  return surface.mesh().positions()[vertex];
}

// A point at a vertex, inside a face, or on a side, in turn.
SurfacePoint some_point(const Surface& surface, std::mt19937& random, std::uint32_t kind) {
  const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
  const double a = 0.1 + 0.8 * (random() / 4294967296.0);
  if (kind % 3 == 0) {
    return point_at_vertex(surface.adjacency(), surface.adjacency().face(f).vertex[0]);
  }
  if (kind % 3 == 1) return point_on_face(surface.adjacency(), f, {a / 2, 1 - a, a / 2});
  return point_on_face(surface.adjacency(), f, {a, 1 - a, 0});
}

// Going straight ahead by an entry's angle for its distance leads to its vertex.
void check_leads_back(const Surface& surface, const SurfacePoint& from, const LogMap& map,
                      double within) {
  for (const LogMap::Entry& entry : map.entries) {
    if (!entry.is_straight) continue;
    CAPTURE(entry.vertex);
    CAPTURE(entry.angle);
    const auto ahead = straightest_geodesic_at_angle(surface.adjacency(), from, entry.angle,
                                                     entry.distance, Cancel());
    REQUIRE(ahead.has_value());
    const double off =
        distance(fixtures::end_of(*ahead), position(surface, entry.vertex)) / size_of(surface);
    CHECK(off <= within);
  }
}

}  // namespace

TEST_CASE("InThePlaneTheMapIsThePlane") {
  std::mt19937 random(test_seed());
  for (std::uint32_t kind = 0; kind < 30; ++kind) {
    CAPTURE(kind);
    TriangleSoup soup = shapes::plane(9, 7);
    for (Vec3& p : soup.positions) {
      p.x += 0.3 * (random() / 4294967296.0);
      p.y += 0.3 * (random() / 4294967296.0);
    }
    const Surface surface(soup);
    const SurfacePoint from = some_point(surface, random, kind);
    const auto map = map_of(surface, from, Method::exact);
    REQUIRE(map.has_value());
    check_leads_back(surface, from, *map, 1e-9);
    // Any two of those that see the point are as far from each other as in space. The outline is
    // not convex, so some do not see it.
    for (std::size_t i = 1; i < map->entries.size(); ++i) {
      const auto& a = map->entries[i];
      const auto& b = map->entries[random() % i];
      const Vec3 source = position_of(surface.mesh(), from);
      const auto sees = [&](const LogMap::Entry& e) {
        return std::abs(e.distance - distance(source, position(surface, e.vertex))) < 1e-12;
      };
      if (!sees(a) || !sees(b)) continue;
      const double there = distance(position(surface, a.vertex), position(surface, b.vertex));
      // A path that is longer by 1e-12 where it bends at a vertex sets out some 1e-6 beside.
      const double within = a.is_straight && b.is_straight ? 1e-7 : 1e-4;
      CHECK(std::abs(norm(map->coordinates(a) - map->coordinates(b)) - there) < within);
    }
  }
}

// A first segment of 1e-16 says nothing of a direction.
TEST_CASE("APointWithinRoundingOfAnEdgeOrAVertexHasAMap") {
  std::mt19937 random(test_seed());
  const auto unit = [&] { return random() / 4294967296.0; };
  for (int i = 0; i < 60; ++i) {
    TriangleSoup soup = shapes::plane(8, 8);
    const double a = 7 * unit();
    const double b = 7 * unit();
    for (Vec3& p : soup.positions) {  // turned in space
      const Vec3 q{std::cos(a) * p.x - std::sin(a) * p.y, std::sin(a) * p.x + std::cos(a) * p.y, 0};
      p = {q.x, std::cos(b) * q.y, std::sin(b) * q.y};
    }
    const Surface surface(soup);
    const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    const double small = std::pow(10.0, -17 + 13 * unit());
    const double other = random() % 2 == 0 ? small * unit() : unit();
    const SurfacePoint from = snap_to_edges(
        surface.adjacency(),
        point_on_face(surface.adjacency(), f, {1 - small - other * (1 - small), other, small}));
    CAPTURE(small);
    CAPTURE(other);
    CAPTURE(f);
    const auto map = map_of(surface, from, random() % 2 == 0 ? Method::exact : Method::back_traced);
    REQUIRE(map.has_value());
    check_leads_back(surface, from, *map, 1e-6);
    for (std::size_t k = 1; k < map->entries.size(); ++k) {
      const auto& one = map->entries[k];
      const auto& two = map->entries[random() % k];
      const double there = distance(position(surface, one.vertex), position(surface, two.vertex));
      // A path that passes the vertex closely may lead to it, and so be turned a little.
      CHECK(std::abs(norm(map->coordinates(one) - map->coordinates(two)) - there) < 1e-3);
    }
  }
}

TEST_CASE("GoingStraightAheadIsTheInverseOnAnySurface") {
  std::mt19937 random(test_seed());
  std::size_t straight = 0;
  for (std::uint32_t i = 0; i < 60; ++i) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const SurfacePoint from = some_point(surface, random, i);
    const auto map = map_of(surface, from, Method::exact);
    if (!map) {
      CHECK(map.error().parameter == "from");
      continue;
    }
    straight += static_cast<std::size_t>(std::count_if(
        map->entries.begin(), map->entries.end(), [](const auto& e) { return e.is_straight; }));
    check_leads_back(surface, from, *map, 1e-6);
  }
  CHECK(straight > 500);
}

TEST_CASE("WithinARadiusThereAreTheVerticesWithinIt") {
  const Surface surface(shapes::icosphere(3));
  const SurfacePoint from = surface.at(17);
  for (const Method method : {Method::exact, Method::back_traced, Method::wavefront}) {
    const Field field = surface.field_by(method, {{from, 0}});
    const auto map = log_map(surface.adjacency(), field, from, 0.7, Cancel());
    REQUIRE(map.has_value());
    std::vector<bool> has_place(surface.mesh().vertex_count());
    for (const LogMap::Entry& entry : map->entries) {
      has_place[entry.vertex] = true;
      CHECK(entry.distance <= 0.7);
    }
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      if (field.distance[v] < 0.68) CHECK(has_place[v]);
    }
    for (const LogMap::Entry& entry : map->entries) {
      CHECK(entry.distance == doctest::Approx(field.distance[entry.vertex]).epsilon(0.02));
    }
    check_leads_back(surface, from, *map, 1e-6);
  }
}

// The sphere about its pole: azimuths are the angles, whatever the method.
TEST_CASE("OnASphereAnglesAreAzimuths") {
  const Surface surface(shapes::icosphere(5));
  const SurfacePoint from = surface.at(0);
  const Vec3 pole = position(surface, from.vertex);
  const auto map = map_of(surface, from, Method::back_traced, 1.0);
  REQUIRE(map.has_value());
  CHECK(map->all_round);
  const auto azimuth = [&](std::uint32_t v, Vec3 x) {
    const Vec3 p = position(surface, v);
    const Vec3 flat = p - dot(p, pole) * pole;
    return std::atan2(dot(cross(x, flat), pole), dot(x, flat));
  };
  Vec3 x{};
  for (const LogMap::Entry& entry : map->entries) {
    if (entry.distance > 0.9 && std::abs(entry.angle) < 0.02) {
      const Vec3 p = position(surface, entry.vertex);
      const Vec3 flat = p - dot(p, pole) * pole;
      x = (1 / norm(flat)) * flat;
    }
  }
  REQUIRE(norm(x) > 0);
  for (const LogMap::Entry& entry : map->entries) {
    if (entry.distance < 0.1) continue;
    const Vec2 at = map->coordinates(entry);
    double off = std::atan2(at.y, at.x) - azimuth(entry.vertex, x);
    off -= 2 * pi * std::round(off / (2 * pi));
    CHECK(std::abs(off) < 0.03);
  }
}

// Six faces of 40 degrees about the apex: a full turn there is 240 degrees.
TEST_CASE("RoundTheApexOfAConeAnglesAreSpread") {
  constexpr std::uint32_t kSides = 6;
  const double side = 40 * pi / 180;
  const double base = std::sin(side / 2) / std::sin(pi / kSides);
  TriangleSoup soup;
  soup.positions.push_back({0, 0, std::sqrt(1 - base * base)});
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const double u = 2 * pi * i / kSides;
    soup.positions.push_back({base * std::cos(u), base * std::sin(u), 0});
    soup.faces.push_back({0, 1 + i, 1 + (i + 1) % kSides});
  }
  const Surface surface(soup);
  const auto map = map_of(surface, surface.at(0), Method::exact);
  REQUIRE(map.has_value());
  CHECK(map->total_angle == doctest::Approx(kSides * side));
  REQUIRE(map->entries.size() == kSides + 1);
  std::vector<double> turns;
  for (const LogMap::Entry& entry : map->entries) {
    if (entry.distance == 0) continue;
    CHECK(entry.distance == doctest::Approx(1));
    const Vec2 at = map->coordinates(entry);
    CHECK(norm(at) == doctest::Approx(1));
    turns.push_back(std::atan2(at.y, at.x));
  }
  std::sort(turns.begin(), turns.end());
  for (std::size_t i = 1; i < turns.size(); ++i) {
    CHECK(turns[i] - turns[i - 1] == doctest::Approx(2 * pi / kSides));
  }
}

TEST_CASE("WhereFacesAreNoFanThereIsNoMap") {
  // Three faces at the edge from 0 to 1.
  TriangleSoup book;
  book.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
  book.faces = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};
  const Surface surface(book);
  const SurfacePoint on_edge = surface.on(0, {0.5, 0.5, 0});
  for (const SurfacePoint& from : {surface.at(0), on_edge}) {
    const auto map = map_of(surface, from, Method::exact);
    REQUIRE_FALSE(map.has_value());
    CHECK(map.error().code == ErrorCode::value_out_of_range);
    CHECK(map.error().parameter == "from");
  }
  CHECK(map_of(surface, surface.on(1, {0.2, 0.3, 0.5}), Method::exact).has_value());
  // Two faces that meet in a vertex alone.
  TriangleSoup bow = book;
  bow.faces = {{0, 1, 2}, {0, 3, 4}};
  CHECK_FALSE(map_of(Surface(bow), Surface(bow).at(0), Method::exact).has_value());
}

// As the apex of a fan of needles that are lines within rounding, a vertex has hardly any angle.
TEST_CASE("WhereThereIsNoAnglePlacesAreNumbers") {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}};
  for (int i = 0; i < 4; ++i) {
    soup.positions.push_back({1.0 + i, i * 1e-13, i % 2 * 1e-13});
    soup.faces.push_back({0, 1U + static_cast<unsigned>(i), 1U + static_cast<unsigned>(i + 1) % 4});
  }
  const Surface surface(soup);
  const auto map = map_of(surface, surface.at(0), Method::exact);
  REQUIRE(map.has_value());
  CHECK(map->entries.size() == 5);
  for (const LogMap::Entry& entry : map->entries) {
    const Vec2 at = map->coordinates(entry, 1);
    CHECK(norm(at) == doctest::Approx(entry.distance));
  }
}

TEST_CASE("AnAxisOfManyTurnsIsAnAxis") {
  const Surface surface(shapes::plane(5, 5));
  const auto map = map_of(surface, surface.at(12), Method::exact);
  REQUIRE(map.has_value());
  for (const double turns : {1.0, -3.0, 1e9}) {
    for (const LogMap::Entry& entry : map->entries) {
      const Vec2 off = map->coordinates(entry, 0.5 + turns * 2 * pi) - map->coordinates(entry, 0.5);
      CHECK(norm(off) < 1e-5);
    }
  }
  // Far from each other, whatever such an angle means.
  CHECK(norm(map->coordinates(map->entries[7], 1e17) - map->coordinates(map->entries[11], 1e17)) >
        0.5);
}

TEST_CASE("AMapIsStoppedInTheMiddle") {
  const Surface surface(shapes::icosphere(4));
  const SurfacePoint from = surface.at(3);
  const Field field = surface.field_by(Method::exact, {{from, 0}});
  std::size_t asked = 0;
  const Cancel counting([&] { return ++asked > 20; });
  const auto map = log_map(surface.adjacency(), field, from, kFar, counting);
  REQUIRE_FALSE(map.has_value());
  CHECK(map.error().code == ErrorCode::cancelled);
}
