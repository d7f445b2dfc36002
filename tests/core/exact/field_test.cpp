// The exact field against closed forms and against the exhaustive oracle.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/among_squares.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/exhaustive_unfolding.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::crumpled;
using fixtures::dented_ball;
using fixtures::grown;
using fixtures::Surface;

namespace {

void check_equal(double got, double wanted, double relative) {
  CAPTURE(got);
  CAPTURE(wanted);
  CHECK(std::abs(got - wanted) <= relative * wanted);
}

std::vector<double> exact_from(const Surface& surface, const SurfacePoint& point) {
  return surface.in_source_order(surface.field_by(Method::exact, {Source{point, 0}}));
}

// `columns` points a round, in rows one apart, on a prism without ends.
TriangleSoup prism(std::uint32_t columns, std::uint32_t rows, double radius) {
  TriangleSoup soup;
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const double turn = 2 * std::numbers::pi * i / columns;
      soup.positions.push_back({radius * std::cos(turn), radius * std::sin(turn), double(j)});
      if (j == 0) continue;
      const std::uint32_t ahead = (i + 1) % columns;
      const std::uint32_t below = (j - 1) * columns;
      soup.faces.push_back({below + i, below + ahead, below + columns + ahead});
      soup.faces.push_back({below + i, below + columns + ahead, below + columns + i});
    }
  }
  return soup;
}

// A cone over a polygon that goes up and down by `zigzag`, in rings of one size each:
// vertex 0 is the tip, then ring r at r times the first one's size.
TriangleSoup cone(std::uint32_t corners, std::uint32_t rings, double depth, double zigzag) {
  TriangleSoup soup;
  soup.positions.push_back({0, 0, 0});
  for (std::uint32_t r = 1; r <= rings; ++r) {
    for (std::uint32_t i = 0; i < corners; ++i) {
      const double turn = 2 * std::numbers::pi * i / corners;
      soup.positions.push_back(double(r) * Vec3{std::cos(turn), std::sin(turn),
                                                depth + (i % 2 == 0 ? zigzag : -zigzag)});
      const std::uint32_t ahead = (i + 1) % corners;
      const std::uint32_t here = 1 + (r - 1) * corners;
      if (r == 1) {
        soup.faces.push_back({0, here + i, here + ahead});
        continue;
      }
      soup.faces.push_back({here - corners + i, here + i, here + ahead});
      soup.faces.push_back({here - corners + i, here + ahead, here - corners + ahead});
    }
  }
  return soup;
}

// The surface of a box with corners at the origin and at (x, y, z), in unit squares.
TriangleSoup box(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  TriangleSoup soup;
  const auto side = [&](std::uint32_t columns, std::uint32_t rows, auto place) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    const TriangleSoup flat = shapes::plane(columns + 1, rows + 1);
    for (const Vec3 p : flat.positions) soup.positions.push_back(place(p.x, p.y));
    for (const auto& t : flat.faces) {
      soup.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  };
  for (const bool far : {false, true}) {
    side(x, y, [&](double u, double v) { return Vec3{u, v, far ? double(z) : 0}; });
    side(x, z, [&](double u, double v) { return Vec3{u, far ? double(y) : 0, v}; });
    side(y, z, [&](double u, double v) { return Vec3{far ? double(x) : 0, u, v}; });
  }
  return soup;
}

std::uint32_t vertex_at(const TriangleSoup& soup, Vec3 position) {
  const auto it = std::find(soup.positions.begin(), soup.positions.end(), position);
  REQUIRE(it != soup.positions.end());
  return static_cast<std::uint32_t>(it - soup.positions.begin());
}

}  // namespace

// Light that its vertices part by angles too small to matter is put together again: by each
// of them it is off by less than rounding, and after all of them too.
TEST_CASE("ExactOnAPlaneThatIsFlatButForAHairIsStraight") {
  for (const double height : {1e-10, 1e-8, 1e-6}) {
    CAPTURE(height);
    std::mt19937 random(11);
    const auto part = [&] { return static_cast<double>(random()) / 4294967296.0; };
    constexpr std::uint32_t kSide = 50;
    TriangleSoup soup = shapes::plane(kSide, kSide);
    for (Vec3& p : soup.positions) {
      const bool inner = p.x > 0 && p.y > 0 && p.x < kSide - 1 && p.y < kSide - 1;
      if (inner) p = {p.x + 0.5 * part(), p.y + 0.5 * part(), height * part()};
    }
    const Surface surface(soup);
    const auto d = exact_from(surface, surface.at(0));
    // A way over hairs is longer by the square of their slope.
    const double rise = 1e-12 + 4 * height * height;
    for (std::size_t v = 0; v < d.size(); ++v) {
      const double straight = std::hypot(soup.positions[v].x, soup.positions[v].y);
      check_equal(d[v], straight, rise);
    }
  }
}

TEST_CASE("PlanesAreExactFromVerticesEdgesAndFaces") {
  for (const auto diagonal : {shapes::Diagonal::rising, shapes::Diagonal::falling}) {
    const TriangleSoup soup = shapes::plane(24, 31, diagonal);
    const Surface surface(soup);
    for (const SurfacePoint& point :
         {surface.at(0), surface.at(23), surface.at(24 * 15 + 11), surface.on(700, {0.5, 0.5, 0}),
          surface.on(41, {0, 0.25, 0.75}), surface.on(800, {0.2, 0.3, 0.5}),
          surface.on(801, {0.999999, 5e-7, 5e-7})}) {
      // Seen from the corner that it is nearest to: of a point 1e-6 from it, its own position has
      // only the digits that the coordinates leave.
      const auto c = static_cast<std::uint32_t>(
          std::max_element(point.bary.begin(), point.bary.end()) - point.bary.begin());
      const Triangle& face = surface.mesh().faces()[point.face];
      const auto positions = surface.mesh().positions();
      const Vec3 corner = positions[face[c]];
      const std::uint32_t n = next_corner(c);
      const std::uint32_t p = previous_corner(c);
      const Vec3 beside = point.bary[n] * (positions[face[n]] - corner) +
                          point.bary[p] * (positions[face[p]] - corner);
      const auto d = exact_from(surface, point);
      for (std::size_t i = 0; i < d.size(); ++i) {
        check_equal(d[i], norm((corner - soup.positions[i]) + beside), 1e-12);
      }
    }
  }
}

TEST_CASE("PathsBendAtTheCornersOfHoles") {
  const std::vector<shapes::Hole> holes{{3, 4, 5}, {11, 9, 4}, {14, 2, 3}};
  std::vector<fixtures::Square> squares;
  for (const shapes::Hole& h : holes) {
    squares.push_back({double(h.first_column), double(h.first_row), double(h.first_column + h.size),
                       double(h.first_row + h.size)});
  }
  for (const auto diagonal : {shapes::Diagonal::rising, shapes::Diagonal::falling}) {
    const TriangleSoup soup = shapes::plane_with_holes(20, 20, holes, diagonal);
    const Surface surface(soup);
    for (const std::uint32_t source : {0U, 46U, 20U * 11U + 8U}) {
      const auto d = exact_from(surface, surface.at(source));
      const Vec3 from = soup.positions[source];
      for (std::uint32_t i = 0; i < d.size(); ++i) {
        if (surface.adjacency().corners(surface.vertex(i)).empty()) continue;
        const Vec3 to = soup.positions[i];
        check_equal(d[i], fixtures::shortest_among(squares, {from.x, from.y}, {to.x, to.y}), 1e-12);
      }
    }
  }
}

// Dudeney 1903: over five of the six walls.
TEST_CASE("TheSpiderWalksFortyFeetToTheFly") {
  const TriangleSoup room = box(30, 12, 12);
  const Surface surface(room);
  const auto d = exact_from(surface, surface.at(vertex_at(room, {0, 6, 11})));
  check_equal(d[vertex_at(room, {30, 6, 1})], 40, 1e-13);
}

TEST_CASE("ACubeUnfolds") {
  const TriangleSoup cube = box(4, 4, 4);
  const Surface surface(cube);
  const auto from_corner = exact_from(surface, surface.at(vertex_at(cube, {0, 0, 0})));
  check_equal(from_corner[vertex_at(cube, {4, 4, 4})], 4 * std::sqrt(5.0), 1e-13);
  check_equal(from_corner[vertex_at(cube, {4, 4, 0})], 4 * std::sqrt(2.0), 1e-13);
  check_equal(from_corner[vertex_at(cube, {4, 3, 2})], std::hypot(6, 3), 1e-13);
  const auto from_middle = exact_from(surface, surface.at(vertex_at(cube, {2, 2, 0})));
  check_equal(from_middle[vertex_at(cube, {2, 2, 4})], 8, 1e-13);
  check_equal(from_middle[vertex_at(cube, {4, 4, 4})], std::hypot(6, 2), 1e-13);
}

TEST_CASE("APrismUnrollsFlat") {
  const std::uint32_t columns = 14;
  const std::uint32_t rows = 12;
  const TriangleSoup soup = prism(columns, rows, 2.5);
  const Surface surface(soup);
  const double width = distance(soup.positions[0], soup.positions[1]);
  const auto d = exact_from(surface, surface.at(2 * columns));
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const double round = width * std::min(i, columns - i);
      const double up = double(j) - 2;
      if (i != 0 || j != 2) check_equal(d[j * columns + i], std::hypot(round, up), 1e-12);
    }
  }
}

// Round the tip a cone opens into a sector. Straight where the angle between two
// points is less than pi, else through the tip: which bends paths, worked out by hand,
// only when the whole angle is over 2 pi.
TEST_CASE("ConesOpenIntoSectors") {
  for (const double zigzag : {0.0, 0.6, 2.0}) {
    for (const double depth : {0.0, 1.5}) {
      const std::uint32_t corners = 12;
      const std::uint32_t rings = 4;
      const TriangleSoup soup = cone(corners, rings, depth, zigzag);
      const Surface surface(soup);
      const auto ring = [&](std::uint32_t r, std::uint32_t i) { return 1 + (r - 1) * corners + i; };
      const Vec3 p = soup.positions[1];
      const Vec3 q = soup.positions[2];
      const double step = std::atan2(norm(cross(p, q)), dot(p, q));
      const auto d = exact_from(surface, surface.at(ring(2, 0)));
      check_equal(d[0], 2 * norm(p), 1e-12);
      // The ways outside the sector of a zigzag rim are no shorter: from the second
      // ring inwards the straight lines stay inside.
      for (std::uint32_t r = 1; r <= 2; ++r) {
        for (std::uint32_t i = r == 2 ? 1 : 0; i < corners; ++i) {
          const double angle = step * std::min(i, corners - i);
          const double a = 2 * norm(p);
          const double b = norm(soup.positions[ring(r, i)]);
          const double straight = std::sqrt(a * a + b * b - 2 * a * b * std::cos(angle));
          CAPTURE(zigzag);
          CAPTURE(i);
          check_equal(d[ring(r, i)], angle < std::numbers::pi ? straight : a + b, 1e-12);
        }
      }
    }
  }
}

TEST_CASE("ExactVsExhaustiveUnfolding") {
  for (std::uint32_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    TriangleSoup soup;
    switch (seed % 5) {
      case 0:
        soup = grown(random, 4 + static_cast<int>(random() % 14));
        break;
      case 1:
        soup = crumpled(random, 4, 1.5, 1);
        break;
      case 2:
        soup = dented_ball(random, 0);
        break;
      case 3:
        soup = crumpled(random, 4, 0.1, 1e-2);
        break;
      default:
        soup = shapes::shuffled(crumpled(random, 4, 0.3, 1), seed);
    }
    const Surface surface(soup);
    fixtures::ExhaustiveUnfolding oracle(soup);
    const auto face = static_cast<std::uint32_t>(random() % soup.faces.size());
    const double far = 2 * surface.field_by(Method::dijkstra, {Source{surface.at(0), 0}}).max + 9;
    const auto compare = [&](const std::vector<double>& got, const std::vector<double>& wanted) {
      double size = 0;
      for (const double d : wanted) size = std::isfinite(d) ? std::max(size, d) : size;
      for (std::size_t i = 0; i < got.size(); ++i) {
        if (!std::isfinite(wanted[i])) {
          CHECK(got[i] == kUnreached);
        } else {
          CHECK(std::abs(got[i] - wanted[i]) <= 1e-11 * size);
        }
      }
    };
    const std::uint32_t v = soup.faces[face][0];
    compare(exact_from(surface, surface.at(v)), oracle.from_vertex(v, far));
    compare(exact_from(surface, surface.on(face, {0.25, 0.25, 0.5})),
            oracle.from_point(face, {0.25, 0.25, 0.5}, far));
    compare(exact_from(surface, surface.on(face, {0, 0.75, 0.25})),
            oracle.from_point(face, {0, 0.75, 0.25}, far));
  }
}

// All pairs of every third vertex, on surfaces where the light of many pseudo-sources meets.
TEST_CASE("TheWayBackIsAsLong") {
  for (std::uint32_t seed = 0; seed < fixtures::all_or(12U, 4U); ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    TriangleSoup soup;
    switch (seed % 4) {
      case 0:  // steps, for ties
        soup = shapes::plane(12, 12);
        for (Vec3& p : soup.positions) p.z = random() % 3 == 0 ? 1 : 0;
        break;
      case 1:  // needles
        soup = shapes::terrain(12, 2, seed);
        for (Vec3& p : soup.positions) p.x *= std::pow(10, -5 * fixtures::fraction(random));
        break;
      case 2:
        soup = dented_ball(random, 2);
        break;
      default:
        soup = shapes::terrain(12, 6, seed);
    }
    const Surface surface(soup);
    FieldLimits limits;
    limits.keep_details = seed % 2 == 0;
    std::vector<std::vector<double>> d;
    for (std::uint32_t v = 0; v < soup.positions.size(); v += 3) {
      d.push_back(surface.in_source_order(
          surface.field_by(Method::exact, {Source{surface.at(v), 0}}, limits)));
    }
    double worst = 0;
    double size = 0;
    for (std::size_t i = 0; i < d.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        worst = std::max(worst, std::abs(d[i][3 * j] - d[j][3 * i]));
        size = std::max(size, d[i][3 * j]);
      }
    }
    CHECK(worst <= 1e-12 * size);
  }
}
