// Figs. 5 to 7 of Tang et al. 2007: planes, whole and with square holes, where the
// geodesic distance has a closed form.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/among_squares.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::check_is_a_path;
using fixtures::Point2;
using fixtures::shortest_among;
using fixtures::Square;
using fixtures::Surface;

namespace {

constexpr std::uint32_t kSide = 100;  // vertices
constexpr Point2 kBottomLeft{0, 0};
constexpr Point2 kTopRight{kSide - 1, kSide - 1};

// A hole round the diagonal, nearer to it below than above, one that narrows the
// way below, and one that closes it.
constexpr shapes::Hole kOnDiagonal{30, 36, 30};
constexpr shapes::Hole kBeyond{74, 64, 12};
constexpr shapes::Hole kAcrossWayBelow{45, 10, 28};
constexpr Point2 kCornerBelow{60, 36};  // of kOnDiagonal
constexpr Point2 kCornerAbove{30, 66};

std::uint32_t vertex_at(Point2 p) {
  return static_cast<std::uint32_t>(p.y) * kSide + static_cast<std::uint32_t>(p.x);
}

std::vector<Square> squares_of(const std::vector<shapes::Hole>& holes) {
  std::vector<Square> squares;
  for (const shapes::Hole& hole : holes) {
    const double x = hole.first_column;
    const double y = hole.first_row;
    squares.push_back({x, y, x + hole.size, y + hole.size});
  }
  return squares;
}

double shortest_by_way_of(const std::vector<Square>& squares, Point2 via) {
  return shortest_among(squares, kBottomLeft, via) + shortest_among(squares, via, kTopRight);
}

// Where, from 0 to 99, the path crosses x + y = 96, the anti-diagonal through
// kOnDiagonal: its x there. The ways on either side of the hole differ in it.
double crossing_of_antidiagonal(const Path& path) {
  constexpr double kSum = 96;
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const Vec3 a = path.points[i].position;
    const Vec3 b = path.points[i + 1].position;
    const double from = a.x + a.y - kSum;
    const double to = b.x + b.y - kSum;
    if (from <= 0 && to > 0) return a.x + (b.x - a.x) * from / (from - to);
  }
  FAIL("the path does not reach the anti-diagonal");
  return 0;
}

enum class Side { below, above };

void check_passes(const Path& path, Side side) {
  const double x = crossing_of_antidiagonal(path);
  const Square hole = squares_of({kOnDiagonal})[0];
  if (side == Side::below) {
    CHECK(x > hole.x1 - 1e-9);
  } else {
    CHECK(x < hole.x0 + 1e-9);
  }
  for (const PathPoint& point : path.points) {
    const Vec3 p = point.position;
    if (p.x < hole.x0 || p.x > hole.x1) continue;
    if (side == Side::below) {
      CHECK(p.y < hole.y0 + 1e-9);
    } else {
      CHECK(p.y > hole.y1 - 1e-9);
    }
  }
}

Path path_to_top_right(const std::vector<shapes::Hole>& holes, shapes::Diagonal diagonal) {
  const Surface surface(shapes::plane_with_holes(kSide, kSide, holes, diagonal));
  const Field field = surface.field_from(vertex_at(kBottomLeft));
  auto path = surface.path(field, surface.at(vertex_at(kTopRight)));
  REQUIRE(path);
  return *path;
}

}  // namespace

TEST_CASE("Fig5PlaneIsExactFromItsCorner") {
  for (const auto diagonal : {shapes::Diagonal::rising, shapes::Diagonal::falling}) {
    const TriangleSoup soup = shapes::plane(kSide, kSide, diagonal);
    const Surface surface(soup);
    const auto distances = surface.in_source_order(surface.field_from(0));
    REQUIRE(distances.size() == std::size_t{kSide} * kSide);
    double worst = 0;
    double squares = 0;
    for (std::size_t i = 0; i < distances.size(); ++i) {
      const double error = std::abs(distances[i] - norm(soup.positions[i]));
      // Not std::max alone, which would let a NaN pass.
      REQUIRE(std::isfinite(error));
      worst = std::max(worst, error);
      squares += error * error;
    }
    const double mean_square = squares / static_cast<double>(distances.size());
    MESSAGE("Fig. 5: max error ", worst, ", mean square error ", mean_square);
    CHECK(worst < 1e-12);
    CHECK(mean_square < 1e-24);
  }
}

TEST_CASE("Figs6And7PlanesWithHolesAgreeWithTheClosedForm") {
  const std::vector<std::vector<shapes::Hole>> cases{
      {{40, 40, 20}}, {kOnDiagonal, kBeyond}, {kOnDiagonal, kBeyond, kAcrossWayBelow}};
  // All over the plane, many of them behind the holes; none inside one.
  const std::vector<Point2> targets{kTopRight, {99, 0},  {0, 99},  {99, 50}, {50, 99},
                                    {95, 70},  {70, 95}, {66, 62}, {62, 72}, {88, 80},
                                    {90, 90},  {75, 30}, {20, 80}, {10, 5}};
  // The paper's own experiment, corner to corner with rising diagonals, holds 0.3 %.
  // Some other targets behind a corner of a hole miss it: a vertex remembers its
  // distance but not the corner at which its path bent, so the circles there are
  // drawn round the wrong centre. Which targets depends on how the squares are cut;
  // the bounds are those that were measured.
  constexpr double kAim = 0.003;
  constexpr double kBound = 0.009;
  double worst = 0;
  std::size_t missed_rising = 0;
  std::size_t missed_falling = 0;
  for (const auto& holes : cases) {
    CAPTURE(holes.size());
    const std::vector<Square> squares = squares_of(holes);
    for (const auto diagonal : {shapes::Diagonal::rising, shapes::Diagonal::falling}) {
      CAPTURE(diagonal == shapes::Diagonal::rising);
      const Surface surface(shapes::plane_with_holes(kSide, kSide, holes, diagonal));
      const Field field = surface.field_from(vertex_at(kBottomLeft));
      for (const Point2 target : targets) {
        CAPTURE(target.x);
        CAPTURE(target.y);
        const double truth = shortest_among(squares, kBottomLeft, target);
        const std::uint32_t vertex = surface.vertex(vertex_at(target));
        const auto path = surface.path(field, surface.at(vertex_at(target)));
        REQUIRE(path);
        check_is_a_path(surface.adjacency(), *path, kSide);
        CHECK(path->length >= truth * (1 - 1e-12));
        const double error =
            std::max(std::abs(field.distance[vertex] - truth) / truth, path->length / truth - 1);
        CHECK(error <= kBound);
        if (diagonal == shapes::Diagonal::rising && target.x == kTopRight.x &&
            target.y == kTopRight.y) {
          CHECK(error <= kAim);
        }
        if (!(error <= kAim)) {
          ++(diagonal == shapes::Diagonal::rising ? missed_rising : missed_falling);
        }
        worst = std::max(worst, error);
      }
    }
  }
  MESSAGE("Figs. 6 and 7: worst relative error ", worst, "; over 0.3 %: ", missed_rising, " and ",
          missed_falling, " of ", cases.size() * targets.size(), " (rising, falling diagonals)");
  CHECK(missed_rising <= 1);
  CHECK(missed_falling <= 21);
}

TEST_CASE("Fig7AThirdHoleSendsThePathToTheOtherSide") {
  const std::vector<shapes::Hole> two{kOnDiagonal, kBeyond};
  const std::vector<shapes::Hole> three{kOnDiagonal, kBeyond, kAcrossWayBelow};
  // That it must is seen from the closed form.
  const std::vector<Square> among_two = squares_of(two);
  const std::vector<Square> among_three = squares_of(three);
  const double below = shortest_by_way_of(among_two, kCornerBelow);
  const double above = shortest_by_way_of(among_two, kCornerAbove);
  REQUIRE(below < 0.98 * above);
  REQUIRE(shortest_among(among_two, kBottomLeft, kTopRight) == doctest::Approx(below));
  const double above_of_three = shortest_by_way_of(among_three, kCornerAbove);
  REQUIRE(shortest_among(among_three, kBottomLeft, kTopRight) == doctest::Approx(above_of_three));
  REQUIRE(above_of_three == doctest::Approx(above));

  for (const auto diagonal : {shapes::Diagonal::rising, shapes::Diagonal::falling}) {
    check_passes(path_to_top_right(two, diagonal), Side::below);
    check_passes(path_to_top_right(three, diagonal), Side::above);
  }
}

TEST_CASE("AFieldOfTwentyThousandVerticesIsComplete") {
  for (const TriangleSoup& soup : {shapes::plane(142, 142), shapes::terrain(142, 10, 3)}) {
    const Surface surface(soup);
    REQUIRE(surface.mesh().vertex_count() == 20'164);
    const Field field = surface.field_from(0);
    CHECK(field.reached == 20'164);
    const std::vector<double> distance = field.distance.values();
    for (const double d : distance) CHECK(std::isfinite(d));
    CHECK(field.distance[surface.vertex(0)] == 0);
    CHECK(field.max == *std::max_element(distance.begin(), distance.end()));
  }
}
