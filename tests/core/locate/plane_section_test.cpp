// Where planes cut surfaces, and what a tape round the section measures.
#include "core/locate/plane_section.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/paths/join_paths.h"
#include "tests/fixtures/mixed_scales.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/to_segment.h"
#include "tests/fixtures/tube.h"

using namespace geodesic;
using fixtures::Surface;
using std::numbers::pi;

namespace {

double unit_of(std::mt19937& random) { return random() / 4294967296.0; }

std::vector<Vec3> positions_of(const Path& path) {
  std::vector<Vec3> positions;
  for (const PathPoint& point : path.points) positions.push_back(point.position);
  positions.pop_back();
  return positions;
}

double length_round(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& corners) {
  double length = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    length += distance(points[corners[i]], points[corners[(i + 1) % corners.size()]]);
  }
  return length;
}

Result<std::vector<SurfacePoint>> cut(const Surface& surface, const SurfacePoint& at, Vec3 normal) {
  return plane_section(surface.adjacency(), at, normal, Cancel());
}

}  // namespace

TEST_CASE("ASectionOfAnySurfaceIsInThePlaneAndOnTheSurfaceAndGoesThroughThePoint") {
  std::mt19937 random(fixtures::test_seed() + 20);
  int closed = 0;
  for (int round = 0; round < 150; ++round) {
    fixtures::RandomMesh mesh(random());
    const Surface surface(mesh.soup());
    const Vec3 normal{mesh.unit() - 0.5, mesh.unit() - 0.5, mesh.unit() - 0.5};
    const bool inside = mesh.unit() < 0.5;
    const auto f = mesh.below(surface.mesh().face_count());
    const SurfacePoint at =
        inside ? point_on_face(surface.adjacency(), f, {0.3, 0.3, 0.4}) : surface.at(mesh.vertex());
    const auto section = cut(surface, at, normal);
    if (!section) {
      CHECK(section.error().code == ErrorCode::no_loop);
      CHECK(section.error().parameter == "normal");
      continue;
    }
    ++closed;
    const Path path = closed_path_along(surface.mesh(), *section);
    const Box& box = surface.mesh().box();
    const double size = distance(box.min, box.max);
    fixtures::check_is_a_path(surface.adjacency(), path, size);
    const Vec3 through = position_of(surface.mesh(), at);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
      const Vec3 a = path.points[i].position;
      const Vec3 b = path.points[i + 1].position;
      CHECK(std::abs(dot(normal, a - through)) <= 1e-12 * size);
      const double t =
          std::clamp(dot(through - a, b - a) / std::max(dot(b - a, b - a), 1e-300), 0.0, 1.0);
      nearest = std::min(nearest, distance(through, (1 - t) * a + t * b));
    }
    CHECK(nearest <= 1e-9 * size);
  }
  CHECK(closed > 0);
}

TEST_CASE("APrismCutStraightAndAslant") {
  std::mt19937 random(fixtures::test_seed() + 21);
  for (int round = 0; round < 20; ++round) {
    const auto n = static_cast<std::uint32_t>(3 + random() % 30);
    const Surface surface(fixtures::tube(n, 8, 4));
    const SurfacePoint at = surface.on(4 * n, {0.2, 0.3, 0.5});
    const double slope = unit_of(random);
    const auto section = cut(surface, at, {-slope, 0, 1});
    REQUIRE(section);
    // Each corner is where the plane z = z0 + slope (x - x0) meets an edge of the prism.
    const Vec3 p = position_of(surface.mesh(), at);
    double length = 0;
    const auto corner = [&](std::uint32_t i) {
      const double angle = 2 * pi * i / n;
      return Vec3{std::cos(angle), std::sin(angle), p.z + slope * (std::cos(angle) - p.x)};
    };
    for (std::uint32_t i = 0; i < n; ++i) length += distance(corner(i), corner(i + 1));
    CHECK(closed_path_along(surface.mesh(), *section).length ==
          doctest::Approx(length).epsilon(1e-12));
  }
}

// Upside down or turned, once or several times.
TEST_CASE("FacesThatAreThereTwiceChangeNoSection") {
  std::mt19937 random(fixtures::test_seed() + 22);
  for (int round = 0; round < 20; ++round) {
    const auto n = static_cast<std::uint32_t>(3 + random() % 20);
    const TriangleSoup once = fixtures::tube(n, 8, 4);
    TriangleSoup twice = once;
    for (std::uint32_t i = 0; i < n; ++i) {
      auto face = once.faces[random() % once.faces.size()];
      std::rotate(face.begin(), face.begin() + random() % 3, face.end());
      if (random() % 2 == 0) std::swap(face[0], face[1]);
      twice.faces.push_back(face);
    }
    const Surface clean(once);
    const Surface copied(twice);
    for (std::uint32_t f = 2 * n; f < 6 * n; f += 1 + random() % 5) {
      const double slope = 0.2 * unit_of(random);
      const auto expected = cut(clean, clean.on(f, {0.2, 0.3, 0.5}), {-slope, 0, 1});
      const auto section = cut(copied, copied.on(f, {0.2, 0.3, 0.5}), {-slope, 0, 1});
      REQUIRE(expected);
      REQUIRE(section);
      CHECK(section->size() == expected->size());
      CHECK(closed_path_along(copied.mesh(), *section).length ==
            doctest::Approx(closed_path_along(clean.mesh(), *expected).length).epsilon(1e-12));
    }
  }
}

TEST_CASE("APlaneThroughVerticesTurnsRoundByEdges") {
  const Surface surface(fixtures::tube(12, 4, 4));
  const auto section = cut(surface, surface.at(30), {0, 0, -2});
  REQUIRE(section);
  CHECK(section->size() == 12);
  for (const SurfacePoint& point : *section) CHECK(point.at_vertex());
}

TEST_CASE("OfCopiesThatAPlaneTouchesTheLastIsNotLookedForFromEach") {
  std::mt19937 random(fixtures::test_seed() + 27);
  TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {0.4, 0.7, 0}}, {}};
  for (int i = 0; i < 3000; ++i) {
    Triangle face{0, 1, 2};
    std::rotate(face.begin(), face.begin() + random() % 3, face.end());
    soup.faces.push_back(face);
  }
  const Surface surface(soup);
  const auto ask = [&](Vec3 normal) {
    std::uint64_t asked = 0;
    const Cancel cancel([&] { return ++asked == 0; });
    const auto section = plane_section(surface.adjacency(), surface.at(0), normal, cancel);
    REQUIRE_FALSE(section);
    // The square of the copies is two thousand questions.
    CHECK(asked < 20);
    return section.error().detail;
  };
  CHECK(ask({1, 1, 0}) == "the plane only touches the surface there, and does not cut it");
  CHECK(ask({1, -1, 0}) ==
        "the section comes to the boundary of the surface there: it is no closed curve");
}

TEST_CASE("SectionsThatAreNoClosedCurves") {
  const Surface open(fixtures::tube(12, 4, 4));
  const auto aslant = cut(open, open.at(30), {1, 0, 0.1});
  REQUIRE_FALSE(aslant);
  CHECK(aslant.error().code == ErrorCode::no_loop);
  CHECK(aslant.error().detail ==
        "the section comes to the boundary of the surface there: it is no closed curve");
  const Surface flat(shapes::plane(5, 5));
  const auto touching = cut(flat, flat.at(12), {0, 0, 1});
  REQUIRE_FALSE(touching);
  CHECK(touching.error().code == ErrorCode::no_loop);
  CHECK(touching.error().detail == "the plane only touches the surface there, and does not cut it");
  // A peak in the plane, from either side.
  const Surface peak({{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}},
                      {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {3, 2, 1}}});
  for (const double up : {1.0, -1.0}) {
    const auto at_peak = cut(peak, peak.at(0), {0, 0, up});
    REQUIRE_FALSE(at_peak);
    CHECK(at_peak.error().code == ErrorCode::no_loop);
    CHECK(at_peak.error().detail ==
          "the plane only touches the surface there, and does not cut it");
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const Vec3 normal : {Vec3{0, 0, 0}, Vec3{kInfinity, 0, 0}, Vec3{0, std::nan(""), 1}}) {
    const auto section = cut(open, open.at(30), normal);
    REQUIRE_FALSE(section);
    CHECK(section.error().code == ErrorCode::value_out_of_range);
    CHECK(section.error().parameter == "normal");
  }
  // The length of a normal plays no part.
  CHECK(cut(open, open.at(30), {0, 0, 1e-320}));
  CHECK(cut(open, open.at(30), {0, 0, 1e300}));
}

// Corners drawn near and far from an axis: the hull is that of the far ones.
TEST_CASE("ATapeRoundAStarTouchesItsTips") {
  std::mt19937 random(fixtures::test_seed() + 22);
  for (int round = 0; round < 20; ++round) {
    const auto tips = static_cast<std::uint32_t>(3 + random() % 12);
    std::vector<Vec3> corners;
    for (std::uint32_t i = 0; i < 2 * tips; ++i) {
      const double angle = pi * i / tips;
      // Less than the chord between two tips is away from the middle.
      const double radius = i % 2 == 0 ? 1 : (0.2 + 0.7 * unit_of(random)) * std::cos(pi / tips);
      corners.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
    TriangleSoup soup;
    const auto n = static_cast<std::uint32_t>(corners.size());
    for (const double z : {0.0, 1.0, 2.0}) {
      for (const Vec3& p : corners) soup.positions.push_back({p.x, p.y, z});
    }
    for (std::uint32_t row = 0; row < 2; ++row) {
      for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = row * n + i;
        const std::uint32_t b = row * n + (i + 1) % n;
        soup.faces.push_back({a, b, b + n});
        soup.faces.push_back({a, b + n, a + n});
      }
    }
    const Surface surface(soup);
    const auto section = cut(surface, surface.on(random() % (2 * n), {0.2, 0.3, 0.5}), {0, 0, 1});
    REQUIRE(section);
    const Path path = closed_path_along(surface.mesh(), *section);
    const std::vector<Vec3> points = positions_of(path);
    const auto hull = hull_in_plane(points, {0, 0, 3}, Cancel());
    REQUIRE(hull);
    CHECK(hull->size() == tips);
    CHECK(length_round(points, *hull) ==
          doctest::Approx(2 * tips * std::sin(pi / tips)).epsilon(1e-12));
    CHECK(length_round(points, *hull) < path.length);
  }
}

// A convex surface is cut in one curve, so that runs through all three.
TEST_CASE("ASectionThroughThreePointsOfAConvexSurfaceIsThere") {
  std::mt19937 random(fixtures::test_seed() + 24);
  int found = 0;
  for (int round = 0; round < 60; ++round) {
    CAPTURE(round);
    TriangleSoup soup = shapes::icosphere(1 + random() % 4);
    const Vec3 stretch{0.3 + unit_of(random), 0.3 + unit_of(random), 0.3 + unit_of(random)};
    for (Vec3& p : soup.positions) p = {p.x * stretch.x, p.y * stretch.y, p.z * stretch.z};
    const Surface surface(soup);
    std::array<SurfacePoint, 3> points;
    for (SurfacePoint& point : points) {
      const auto face = static_cast<std::uint32_t>(random() % soup.faces.size());
      point = random() % 3 == 0
                  ? surface.at(soup.faces[face][0])
                  : surface.on(face, {unit_of(random), unit_of(random), unit_of(random)});
    }
    const auto section = section_through(surface.adjacency(), points, Cancel());
    if (!section) {
      // Two of them are at one vertex, or all three in one face.
      const bool is_line = section.error().code == ErrorCode::value_out_of_range;
      CHECK((is_line || section.error().detail.find("along a face") != std::string::npos));
      CHECK(section.error().parameter == "around");
      continue;
    }
    ++found;
    const Vec3 up = (1 / norm(section->normal)) * section->normal;
    const Vec3 first = position_of(surface.mesh(), points[0]);
    for (const SurfacePoint& point : section->points) {
      CHECK(std::abs(dot(up, position_of(surface.mesh(), point) - first)) < 1e-9);
    }
    for (const SurfacePoint& point : points) {
      double least = std::numeric_limits<double>::infinity();
      Vec3 before = position_of(surface.mesh(), section->points.back());
      for (const SurfacePoint& next : section->points) {
        const Vec3 here = position_of(surface.mesh(), next);
        least =
            std::min(least, fixtures::to_segment(position_of(surface.mesh(), point), before, here));
        before = here;
      }
      CHECK(least < 1e-9);
    }
  }
  CHECK(found > 30);
}

// A plane through vertices may leave them on either side: whichever it is, in every order the same.
TEST_CASE("TheOrderOfThreePointsDoesNotMatter") {
  std::mt19937 random(fixtures::test_seed() + 25);
  int found = 0;
  for (int round = 0; round < 500; ++round) {
    CAPTURE(round);
    fixtures::RandomMesh mesh(random());
    TriangleSoup soup = mesh.soup();
    // On a lattice many vertices lie in one plane.
    if (round % 2 == 0) {
      const Surface bare(soup);
      const double step = norm(bare.mesh().box().max - bare.mesh().box().min) / 6;
      for (Vec3& p : soup.positions) {
        p = {step * std::round(p.x / step), step * std::round(p.y / step),
             step * std::round(p.z / step)};
      }
    }
    if (!Mesh::build(soup, Weld::by_position, Cancel())) continue;
    const Surface surface(soup);
    std::array<std::uint32_t, 3> at{};
    for (std::uint32_t& v : at) v = random() % surface.mesh().vertex_count();
    std::sort(at.begin(), at.end());
    std::optional<double> length;
    std::optional<ErrorCode> code;
    do {
      const std::array points{point_at_vertex(surface.adjacency(), at[0]),
                              point_at_vertex(surface.adjacency(), at[1]),
                              point_at_vertex(surface.adjacency(), at[2])};
      const auto section = section_through(surface.adjacency(), points, Cancel());
      const double here = section ? closed_path_along(surface.mesh(), section->points).length : -1;
      const ErrorCode wrong = section ? ErrorCode::cancelled : section.error().code;
      if (length) {
        CHECK(here == *length);
        CHECK(wrong == *code);
      }
      length = here;
      code = wrong;
      if (section) ++found;
    } while (std::next_permutation(at.begin(), at.end()));
  }
  CHECK(found > 30);
}

TEST_CASE("APlaneAlongAFaceSaysSo") {
  std::mt19937 random(fixtures::test_seed() + 26);
  int refused = 0;
  for (int round = 0; round < 40; ++round) {
    CAPTURE(round);
    const Surface surface(shapes::icosphere(round % 3));
    const auto face = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    std::array<SurfacePoint, 3> points;
    for (std::size_t i = 0; i < 3; ++i) {
      std::array<double, 3> bary{0.1 * unit_of(random), 0.1 * unit_of(random),
                                 0.1 * unit_of(random)};
      bary[i] = 1;
      points[i] = surface.on(face, bary);
    }
    const auto section = section_through(surface.adjacency(), points, Cancel());
    if (section) continue;  // to rounding, it is the face's own outline
    ++refused;
    CHECK(section.error().code == ErrorCode::no_loop);
    CHECK(section.error().parameter == "around");
    CHECK(section.error().detail.find("along a face") != std::string::npos);
  }
  CHECK(refused > 0);
}

// By Cauchy's formula the perimeter of a convex shape is the mean of its widths times pi.
TEST_CASE("AHullIsAsLongAsItsWidthsSay") {
  std::mt19937 random(fixtures::test_seed() + 23);
  for (int round = 0; round < 20; ++round) {
    std::vector<Vec3> points;
    const std::size_t count = 1 + random() % 40;
    const Vec3 normal{unit_of(random), unit_of(random) - 0.5, 0.1};
    Vec3 x = cross(normal, {0, 0, 1});
    x = (1 / norm(x)) * x;
    Vec3 y = cross(normal, x);
    y = (1 / norm(y)) * y;
    for (std::size_t i = 0; i < count; ++i) {
      points.push_back(unit_of(random) * x + (unit_of(random) * unit_of(random)) * y);
      if (random() % 4 == 0) points.push_back(points[random() % points.size()]);  // twice
    }
    const auto hull = hull_in_plane(points, normal, Cancel());
    REQUIRE(hull);
    constexpr int kDirections = 20'000;
    double sum = 0;
    for (int k = 0; k < kDirections; ++k) {
      const double angle = pi * (k + 0.5) / kDirections;
      const Vec3 along = std::cos(angle) * x + std::sin(angle) * y;
      double low = std::numeric_limits<double>::infinity();
      double high = -low;
      for (const Vec3& p : points) {
        low = std::min(low, dot(along, p));
        high = std::max(high, dot(along, p));
      }
      sum += high - low;
    }
    CHECK(length_round(points, *hull) == doctest::Approx(pi * sum / kDirections).epsilon(1e-6));
  }
  CHECK(hull_in_plane({}, {0, 0, 1}, Cancel())->empty());
}

TEST_CASE("SectionsAndHullsAreCancelledAndAskForMemory") {
  const Surface surface(fixtures::tube(20'000, 3, 1));
  const SurfacePoint at = surface.on(100, {0.2, 0.3, 0.5});
  const Cancel cancel([] { return true; });
  const auto section = plane_section(surface.adjacency(), at, {0, 0, 1}, cancel);
  REQUIRE_FALSE(section);
  CHECK(section.error().code == ErrorCode::cancelled);
  const std::vector<Vec3> points(20'000);
  const auto hull = hull_in_plane(points, {0, 0, 1}, cancel);
  REQUIRE_FALSE(hull);
  CHECK(hull.error().code == ErrorCode::cancelled);
  MemoryBudget budget([](std::uint64_t bytes) -> std::optional<Error> {
    if (bytes < 500'000) return std::nullopt;
    return Error{ErrorCode::too_large, "no more", {}, {}, {}};
  });
  const Cancel poor({}, {}, &budget);
  const auto dear = plane_section(surface.adjacency(), at, {0, 0, 1}, poor);
  REQUIRE_FALSE(dear);
  CHECK(dear.error().detail == "no more");
  REQUIRE_FALSE(hull_in_plane(points, {0, 0, 1}, poor));
}
