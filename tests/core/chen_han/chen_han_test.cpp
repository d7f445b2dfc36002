// Chen and Han's method where the answer is known: flat surfaces, surfaces that
// develop flat, hand-worked saddles, and the surfaces that break public codes.
#include "core/chen_han/chen_han.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/field/window_table.h"
#include "core/mesh/shapes.h"
#include "tests/fixtures/among_squares.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

constexpr double kExact = 1e-12;

std::vector<double> chen_han_distances(const Surface& surface, std::uint32_t from) {
  return surface.in_source_order(surface.field_by(Method::chen_han, {Source{surface.at(from), 0}}));
}

void check_nearly(double value, double expected) {
  CHECK(std::abs(value - expected) <= kExact * std::abs(expected));
}

void append(TriangleSoup& soup, const TriangleSoup& part) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), part.positions.begin(), part.positions.end());
  for (const Triangle& t : part.faces) {
    soup.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

// The unit cube's surface, each face n x n squares, seams welded.
TriangleSoup cube(std::uint32_t n) {
  TriangleSoup soup;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double level : {0.0, 1.0}) {
      TriangleSoup side = shapes::plane(n + 1, n + 1);
      for (Vec3& p : side.positions) {
        const std::array<double, 3> at{p.x / n, p.y / n, level};
        p = {at[(3 - axis) % 3], at[(4 - axis) % 3], at[(5 - axis) % 3]};
      }
      append(soup, side);
    }
  }
  return soup;
}

std::uint32_t vertex_at(const TriangleSoup& soup, Vec3 p) {
  std::uint32_t best = 0;
  for (std::uint32_t v = 0; v < soup.positions.size(); ++v) {
    if (distance(soup.positions[v], p) < distance(soup.positions[best], p)) best = v;
  }
  REQUIRE(distance(soup.positions[best], p) < 1e-9);
  return best;
}

// What the header promises of windows: the least over those that light the face, its
// corners and the sources in it.
double distance_in_face(const Adjacency& adjacency, const Field& field, const SurfacePoint& point) {
  const FaceRecord& face = adjacency.face(point.face);
  const auto positions = adjacency.mesh().positions();
  const Vec3 at = position_of(adjacency.mesh(), point);
  double best = kUnreached;
  for (const Source& source : field.sources) {
    for (const SurfacePoint& place : in_all_faces(adjacency, source.point)) {
      if (place.face != point.face) continue;
      best =
          std::min(best, source.offset + distance(at, position_of(adjacency.mesh(), source.point)));
    }
  }
  for (std::uint32_t c = 0; c < 3; ++c) {
    const Vec3 a = positions[face.vertex[c]];
    const Vec3 b = positions[face.vertex[next_corner(c)]];
    best = std::min(best, field.distance[face.vertex[c]] + distance(at, a));
    const double base = distance(a, b);
    const double x = dot(at - a, b - a) / base;
    const double y = norm(cross(at - a, b - a)) / base;
    for (const VisibleInterval& w : field.windows->into(halfedge(point.face, c))) {
      CHECK(0 <= w.begin);
      CHECK(w.begin < w.end);
      CHECK(w.end <= base * (1 + kExact));
      CHECK(w.y >= 0);
      const double crossing = w.x + (x - w.x) * w.y / (w.y + y);
      if (crossing < w.begin - 1e-12 || crossing > w.end + 1e-12) continue;
      best = std::min(best, w.offset + std::hypot(x - w.x, y + w.y));
    }
  }
  return best;
}

}  // namespace

TEST_CASE("ChenHanPlaneIsFlatOnBothDiagonals") {
  for (const auto diagonal : {shapes::Diagonal::rising, shapes::Diagonal::falling}) {
    const std::uint32_t n = 18;
    const Surface surface(shapes::plane(n, n, diagonal));
    for (const std::uint32_t from : {0U, 5 * n + 7, n - 1}) {
      const auto d = chen_han_distances(surface, from);
      for (std::uint32_t v = 0; v < n * n; ++v) {
        const double dx = double(v % n) - double(from % n);
        const double dy = double(v / n) - double(from / n);
        check_nearly(d[v], std::hypot(dx, dy));
      }
    }
  }
}

TEST_CASE("ChenHanBendsAtTheCornersOfHoles") {
  const std::uint32_t n = 16;
  const std::array<shapes::Hole, 3> holes{{{3, 2, 4}, {9, 5, 3}, {4, 9, 5}}};
  std::vector<fixtures::Square> squares;
  for (const shapes::Hole& h : holes) {
    const double x = h.first_column;
    const double y = h.first_row;
    squares.push_back({x, y, x + h.size, y + h.size});
  }
  for (const auto diagonal : {shapes::Diagonal::rising, shapes::Diagonal::falling}) {
    const Surface surface(shapes::plane_with_holes(n, n, holes, diagonal));
    const auto d = chen_han_distances(surface, 0);
    for (std::uint32_t v = 0; v < n * n; ++v) {
      if (surface.adjacency().corners(surface.vertex(v)).empty()) {
        CHECK(d[v] == kUnreached);
        continue;
      }
      const fixtures::Point2 to{double(v % n), double(v / n)};
      check_nearly(d[v], fixtures::shortest_among(squares, {0, 0}, to));
    }
  }
}

TEST_CASE("ChenHanUnfoldsTheCube") {
  for (const std::uint32_t n : {1U, 2U, 4U}) {
    const TriangleSoup soup = cube(n);
    const Surface surface(soup);
    CHECK(surface.adjacency().report().edges_boundary == 0);
    const auto d = chen_han_distances(surface, vertex_at(soup, {0, 0, 0}));
    check_nearly(d[vertex_at(soup, {1, 0, 0})], 1);
    check_nearly(d[vertex_at(soup, {1, 1, 0})], std::sqrt(2.0));
    check_nearly(d[vertex_at(soup, {1, 1, 1})], std::sqrt(5.0));
    if (n == 1) continue;
    // Up a side and on over the top, by the shorter of the two unfoldings.
    check_nearly(d[vertex_at(soup, {0.5, 1, 0.5})], std::hypot(1.5, 0.5));
    check_nearly(d[vertex_at(soup, {1, 0.5, 1})], std::hypot(1.5, 1));
    const auto middle = chen_han_distances(surface, vertex_at(soup, {0.5, 0.5, 0}));
    check_nearly(middle[vertex_at(soup, {0.5, 0.5, 1})], 2);
    check_nearly(middle[vertex_at(soup, {0, 0, 1})], std::hypot(1.5, 0.5));
  }
}

TEST_CASE("ChenHanDevelopsATube") {
  const std::uint32_t around = 9;
  const std::uint32_t rows = 12;
  TriangleSoup tube;
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const double u = 2 * std::numbers::pi * i / around;
      tube.positions.push_back({std::cos(u), std::sin(u), 0.3 * j});
    }
  }
  for (std::uint32_t j = 0; j + 1 < rows; ++j) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = j * around + i;
      const std::uint32_t b = j * around + (i + 1) % around;
      tube.faces.push_back({a, b, b + around});
      tube.faces.push_back({a, b + around, a + around});
    }
  }
  const Surface surface(tube);
  const double side = 2 * std::sin(std::numbers::pi / around);
  const std::uint32_t from = 3 * around + 2;
  const auto d = chen_han_distances(surface, from);
  for (std::uint32_t v = 0; v < around * rows; ++v) {
    const std::uint32_t apart = (v % around + around - from % around) % around;
    const double round = side * std::min(apart, around - apart);
    check_nearly(d[v], std::hypot(round, 0.3 * (double(v / around) - 3)));
  }
}

TEST_CASE("ChenHanDevelopsACone") {
  // Forty faces round an apex; one side view of it spans 1.2 pi.
  const std::uint32_t around = 40;
  const double angle = 1.2 * std::numbers::pi / around;
  const double radius = std::sin(angle / 2) / std::sin(std::numbers::pi / around);
  TriangleSoup cone{{{0, 0, 0}}, {}};
  for (std::uint32_t i = 0; i < around; ++i) {
    const double u = 2 * std::numbers::pi * i / around;
    cone.positions.push_back(
        {radius * std::cos(u), radius * std::sin(u), -std::sqrt(1 - radius * radius)});
    cone.faces.push_back({0, 1 + i, 1 + (i + 1) % around});
  }
  const auto d = chen_han_distances(Surface(cone), 1);
  for (std::uint32_t i = 1; i < around; ++i) {
    CHECK(d[1 + i] ==
          doctest::Approx(2 * std::sin(angle * std::min(i, around - i) / 2)).epsilon(1e-12));
  }
  check_nearly(d[0], 1);
}

TEST_CASE("ChenHanBendsAtASaddle") {
  // Five squares at one vertex.
  const std::array<Vec3, 5> out{{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, {0, -1, 0}}};
  TriangleSoup soup{{{0, 0, 0}}, {}};
  for (std::uint32_t i = 0; i < 5; ++i) {
    soup.positions.push_back(out[i]);                     // 1 + 2 i
    soup.positions.push_back(out[i] + out[(i + 1) % 5]);  // 2 + 2 i
    const std::uint32_t next = 1 + 2 * ((i + 1) % 5);
    soup.faces.push_back({0, 1 + 2 * i, 2 + 2 * i});
    soup.faces.push_back({0, 2 + 2 * i, next});
  }
  const Surface surface(soup);
  const auto d = chen_han_distances(surface, 1);
  check_nearly(d[0], 1);
  check_nearly(d[3], std::sqrt(2.0));
  check_nearly(d[4], std::hypot(2, 1));
  check_nearly(d[5], 2);                   // straight through the vertex
  check_nearly(d[6], 1 + std::sqrt(2.0));  // 225 degrees on either side of it
}

TEST_CASE("ChenHanSourcesOnEdgesAndInFaces") {
  const std::uint32_t n = 9;
  const Surface surface(shapes::plane(n, n));
  for (const std::array<double, 3> bary :
       {std::array<double, 3>{0.2, 0.3, 0.5}, {0, 0.25, 0.75}, {0.5, 0.5, 0}}) {
    for (const std::uint32_t face : {0U, 41U, 70U, 127U}) {
      const SurfacePoint point = surface.on(face, bary);
      const Vec3 at = position_of(surface.mesh(), point);
      const Field field = surface.field_by(Method::chen_han, {Source{point, 0.5}});
      CHECK(field.nearest_source.empty());
      CHECK(field.reached == n * n);
      for (std::uint32_t v = 0; v < n * n; ++v) {
        check_nearly(field.distance[surface.vertex(v)],
                     0.5 + distance(at, {double(v % n), double(v / n), 0}));
      }
    }
  }
}

TEST_CASE("ChenHanSeveralSourcesAreTheLeastOfSingleOnes") {
  const Surface surface(shapes::terrain(14, 4, 3));
  const std::vector<Source> sources{{surface.at(20), 0.7},
                                    {surface.on(100, {0.2, 0.2, 0.6}), 0},
                                    {surface.on(300, {0.5, 0.5, 0}), 1.5},
                                    {surface.on(101, {0.3, 0.3, 0.4}), 0.1},
                                    {surface.at(190), 0},
                                    {surface.at(21), 40}};
  const Field all = surface.field_by(Method::chen_han, sources);
  std::vector<Field> single;
  for (const Source& source : sources) {
    single.push_back(surface.field_by(Method::chen_han, {source}));
  }
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    double least = kUnreached;
    for (const Field& field : single) least = std::min(least, field.distance[v]);
    check_nearly(all.distance[v], least);
    REQUIRE(all.nearest_source[v] < sources.size());
    check_nearly(single[all.nearest_source[v]].distance[v], least);
  }
}

TEST_CASE("ChenHanStopsAtTheLimit") {
  const Surface surface(shapes::terrain(14, 4, 3));
  const std::vector<Source> sources{{surface.at(20), 0}};
  const Field whole = surface.field_by(Method::chen_han, sources);
  FieldLimits limits;
  limits.max = 0.4 * whole.max;
  const Field near = surface.field_by(Method::chen_han, sources, limits);
  CHECK(near.reached > 10);
  CHECK(near.reached < whole.reached);
  for (std::size_t v = 0; v < whole.distance.size(); ++v) {
    CHECK(near.distance[v] == (whole.distance[v] <= limits.max ? whole.distance[v] : kUnreached));
  }
}

TEST_CASE("ChenHanStopsAtTheTargets") {
  const Surface surface(shapes::terrain(14, 4, 3));
  const std::vector<Source> sources{{surface.at(20), 0}, {surface.on(300, {0.3, 0.3, 0.4}), 0.1}};
  const Field whole = surface.field_by(Method::chen_han, sources);
  const std::vector<std::uint32_t> targets{surface.vertex(40), surface.vertex(77),
                                           surface.vertex(40), surface.vertex(20)};
  FieldLimits limits;
  limits.targets = targets;
  const Field some = surface.field_by(Method::chen_han, sources, limits);
  double farthest = 0;
  for (const std::uint32_t v : targets) {
    check_nearly(some.distance[v], whole.distance[v]);
    farthest = std::max(farthest, whole.distance[v]);
  }
  CHECK(some.reached < whole.reached);
  for (std::size_t v = 0; v < whole.distance.size(); ++v) {
    if (whole.distance[v] > farthest) {
      CHECK(some.distance[v] == kUnreached);
      CHECK(some.nearest_source[v] == kNone);
    } else {
      check_nearly(some.distance[v], whole.distance[v]);
    }
  }
}

TEST_CASE("ChenHanWindowsAnswerPointsInsideFaces") {
  TriangleSoup soup = shapes::terrain(7, 3, 5);
  SUBCASE("OnATerrain") {}
  SUBCASE("WithAThirdPage") {
    TriangleSoup page = shapes::terrain(7, 2, 8);
    for (Vec3& p : page.positions) p = {p.x, -p.z, p.y + 3};
    for (std::uint32_t i = 0; i < 7; ++i) page.positions[i] = soup.positions[21 + i];
    append(soup, page);
  }
  SUBCASE("WithDuplicateFaces") {
    for (std::size_t f = 0; f < 72; f += 5) {
      soup.faces.push_back({soup.faces[f][2], soup.faces[f][1], soup.faces[f][0]});
    }
  }
  const Surface surface(soup);
  const std::vector<Source> sources{{surface.at(3), 0}, {surface.on(50, {0.2, 0.3, 0.5}), 0.4}};
  const Field field = surface.field_by(Method::chen_han, sources);
  REQUIRE(field.windows);
  for (std::uint32_t f = 0; f < surface.mesh().source_face_count(); ++f) {
    const SurfacePoint point = surface.on(f, {0.2, 0.5, 0.3});
    // The way back is as long.
    const Field back = surface.field_by(Method::chen_han, {Source{point, 0}});
    double expected = back.distance[surface.vertex(3)];
    expected =
        std::min(expected, 0.4 + distance_in_face(surface.adjacency(), back, sources[1].point));
    CHECK(distance_in_face(surface.adjacency(), field, point) ==
          doctest::Approx(expected).epsilon(1e-9));
  }
}

TEST_CASE("ChenHanKeepsNoWindowsUnasked") {
  const Surface surface(shapes::icosphere(1));
  FieldLimits limits;
  limits.keep_details = false;
  const Field field = surface.field_by(Method::chen_han, {Source{surface.at(0), 0}}, limits);
  CHECK(field.windows == nullptr);
  CHECK(field.parents.empty());
  CHECK(field.reached == surface.mesh().vertex_count());
}

TEST_CASE("ChenHanIsCancelled") {
  const Surface surface(shapes::terrain(40, 4, 3));
  ChenHanScratch scratch;
  const std::vector<Source> sources{{surface.at(0), 0}};
  const auto result =
      chen_han_field(surface.adjacency(), sources, {}, scratch, Cancel([] { return true; }));
  REQUIRE_FALSE(result.has_value());
  CHECK(result.error().code == ErrorCode::cancelled);
  // The same scratch memory serves the next query.
  const auto again = chen_han_field(surface.adjacency(), sources, {}, scratch, Cancel());
  REQUIRE(again.has_value());
  CHECK(again->distance == surface.field_by(Method::chen_han, sources).distance);
}
