#include "core/paths/isolines.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint64_t kPlenty = 10'000'000;

std::vector<Isoline> lines_of(const Surface& surface, const Field& field,
                              const std::vector<double>& levels) {
  auto lines = isolines(surface.adjacency(), field, levels, kPlenty, Cancel());
  REQUIRE(lines);
  return std::move(*lines);
}

// The oracle: every face on its own, by the definition.
double length_face_by_face(const Surface& surface, const Field& field, double level) {
  double total = 0;
  for (const auto& t : surface.mesh().faces()) {
    const auto reached = [&](std::uint32_t v) { return std::isfinite(field.distance[v]); };
    if (!std::all_of(t.begin(), t.end(), reached)) continue;
    std::vector<Vec3> ends;
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t u = t[c];
      const std::uint32_t v = t[(c + 1) % 3];
      const double du = field.distance[u] - level;
      const double dv = field.distance[v] - level;
      if ((du >= 0) == (dv >= 0)) continue;
      const auto p = surface.mesh().positions();
      ends.push_back(p[u] + du / (du - dv) * (p[v] - p[u]));
    }
    if (ends.size() == 2) total += distance(ends[0], ends[1]);
  }
  return total;
}

double total_length(const std::vector<Isoline>& lines) {
  double total = 0;
  for (const Isoline& line : lines) total += line.length;
  return total;
}

// What holds for every line: two points or more, none repeated in a row, and the
// stated length is theirs.
void check_lines(const std::vector<Isoline>& lines) {
  for (const Isoline& line : lines) {
    REQUIRE(line.points.size() >= 2);
    double length = line.closed ? distance(line.points.back(), line.points.front()) : 0;
    for (std::size_t i = 1; i < line.points.size(); ++i) {
      CHECK_FALSE(line.points[i] == line.points[i - 1]);
      length += distance(line.points[i], line.points[i - 1]);
    }
    if (line.closed) CHECK_FALSE(line.points.front() == line.points.back());
    CHECK(line.length == doctest::Approx(length).epsilon(1e-12));
  }
}

}  // namespace

TEST_CASE("IsolinesOfAPlaneAreCirclesAndTheErrorFallsWithTheSquareOfTheEdges") {
  double before = 0;
  for (const std::uint32_t half : {10U, 20U, 40U, 80U}) {
    const std::uint32_t side = 2 * half + 1;
    const Surface surface(shapes::plane(side, side));
    const Field field = surface.field_from(half * side + half);
    const double radius = 0.7123 * half;
    const auto lines = lines_of(surface, field, {radius});
    check_lines(lines);
    REQUIRE(lines.size() == 1);
    CHECK(lines[0].closed);
    CHECK(lines[0].level == radius);
    const Vec3 centre{double(half), double(half), 0};
    double worst = 0;
    for (const Vec3 p : lines[0].points) {
      worst = std::max(worst, std::abs(distance(p, centre) - radius));
    }
    CHECK(worst < 0.25 / radius);  // an edge of length sqrt(2) bulges by its square over 8 r
    const double error = std::abs(lines[0].length / (2 * kPi * radius) - 1);
    CHECK(error < 0.01);
    if (before != 0) CHECK(error < before / 3);
    before = error;
  }
}

TEST_CASE("IsolinesEndAtTheBoundary") {
  const Surface surface(shapes::plane(61, 61));
  const auto lines = lines_of(surface, surface.field_from(0), {10.5, 20.25, 40.125});
  check_lines(lines);
  REQUIRE(lines.size() == 3);
  for (const Isoline& line : lines) {
    CHECK_FALSE(line.closed);
    CHECK(line.length == doctest::Approx(kPi / 2 * line.level).epsilon(1e-3));
    const Vec3 a = line.points.front();
    const Vec3 b = line.points.back();
    CHECK(std::min(a.x, a.y) == 0);
    CHECK(std::min(b.x, b.y) == 0);
    CHECK(std::max(a.x, a.y) == doctest::Approx(line.level));
    CHECK(std::max(b.x, b.y) == doctest::Approx(line.level));
  }
}

TEST_CASE("IsolinesThroughVerticesAreWholeAndHaveNoPointTwice") {
  const Surface surface(shapes::plane(21, 21));
  // 5, 10 and 13 are hypotenuses between whole numbers; along edges all are whole.
  const auto straight = lines_of(surface, surface.field_from(0), {5, 10, 13});
  check_lines(straight);
  REQUIRE(straight.size() == 3);
  for (const Isoline& line : straight) {
    CHECK(line.length == doctest::Approx(kPi / 2 * line.level).epsilon(0.01));
  }
  // Rising diagonals: at (i, j) the distance along edges is max + (sqrt 2 - 1) min.
  const Field along = surface.field_by(Method::dijkstra, {Source{surface.at(0), 0}});
  const auto edges = lines_of(surface, along, {1, 2, 3, 7, 20});
  check_lines(edges);
  REQUIRE(edges.size() == 5);
  for (const Isoline& line : edges) {
    // From (level, 0) to (level / sqrt 2, level / sqrt 2) and on to (0, level).
    const double kink = line.level / std::sqrt(2.0);
    const double half = std::hypot(line.level - kink, kink);
    CHECK(line.length == doctest::Approx(2 * half).epsilon(1e-9));
  }
}

TEST_CASE("APeakAtItsLevelIsNoLineAndJustBelowItIsOne") {
  const Surface surface(shapes::icosphere(3));
  const Field field = surface.field_from(0);
  CHECK(lines_of(surface, field, {field.max}).empty());
  CHECK(lines_of(surface, field, {0, field.max * 1.5}).empty());
  const auto lines = lines_of(surface, field, {std::nextafter(field.max, 0.0), 0.999 * field.max});
  CHECK(lines.empty() == false);
  check_lines({lines.back()});
  CHECK(lines.back().closed);
  CHECK(lines.back().length < 0.1);
}

TEST_CASE("IsolinesAscendByLevelAndAreTheSameTwice") {
  const Surface surface(shapes::terrain(40, 6, 3));
  const Field field = surface.field_from(820);
  std::vector<double> levels;
  for (int i = 1; i <= 30; ++i) levels.push_back(field.max * i / 31);
  const auto lines = lines_of(surface, field, levels);
  const auto again = lines_of(surface, field, levels);
  REQUIRE(lines.size() == again.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i > 0) CHECK(lines[i].level >= lines[i - 1].level);
    CHECK(lines[i].points == again[i].points);
  }
}

TEST_CASE("IsolinesOnThreePagesEndAtTheSpineAndMeetThere") {
  const Surface surface(fixtures::book_of_three_pages());
  const Field field = surface.field_from(2);  // (2, 0) on the first page
  const auto lines = lines_of(surface, field, {2.5});
  check_lines(lines);
  REQUIRE(lines.size() == 3);
  std::vector<double> at_spine;
  for (const Isoline& line : lines) {
    CHECK_FALSE(line.closed);
    for (const Vec3 end : {line.points.front(), line.points.back()}) {
      if (end.x == 0 && end.z == 0) at_spine.push_back(end.y);
    }
  }
  REQUIRE(at_spine.size() == 3);
  CHECK(at_spine[0] == at_spine[1]);
  CHECK(at_spine[0] == at_spine[2]);
  CHECK(at_spine[0] == doctest::Approx(1.5).epsilon(0.05));
}

TEST_CASE("FacesWithAnUnreachedVertexHaveNoLine") {
  const Surface two(fixtures::two_components());
  for (const Isoline& line : lines_of(two, two.field_from(0), {1.5, 3.5, 5})) {
    for (const Vec3 p : line.points) CHECK(p.x <= 4);
  }
  const Surface surface(shapes::plane(31, 31));
  const Source middle{surface.at(15 * 31 + 15), 0};
  FieldLimits limits;
  limits.max = 10;
  const auto lines = lines_of(surface, surface.field({middle}, limits), {8.25, 9.75});
  check_lines(lines);
  CHECK(lines.size() > 2);  // 8.25 whole, 9.75 in pieces
  CHECK(lines[0].closed);
  CHECK(lines[0].length == doctest::Approx(2 * kPi * 8.25).epsilon(0.01));
  for (std::size_t i = 1; i < lines.size(); ++i) CHECK_FALSE(lines[i].closed);
}

TEST_CASE("TwoFacesBackToBackHaveALoopOfTwoSegments") {
  const Surface pillow(TriangleSoup{{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, {{0, 1, 2}, {0, 2, 1}}});
  const auto lines = lines_of(pillow, pillow.field_from(0), {2});
  check_lines(lines);
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].closed);
  CHECK(lines[0].points.size() == 2);
  CHECK(lines[0].length == doctest::Approx(2 * std::sqrt(8.0)));
}

TEST_CASE("TotalLengthOfIsolinesIsThatOfTheFacesOneByOne") {
  const auto check = [](const std::string& name, const TriangleSoup& soup, std::uint32_t source) {
    CAPTURE(name);
    const Surface surface(soup);
    const Field field = surface.field_from(source);
    if (field.max == 0) return;
    for (const double part : {0.1, 0.37, 0.5, 0.81, 1.0}) {
      // One level anywhere, one that is the distance of a vertex.
      const double at_vertex = field.distance[surface.vertex(soup.faces[0][1])];
      for (const double level : {part * field.max, part * at_vertex}) {
        if (!std::isfinite(level)) continue;
        const auto lines = lines_of(surface, field, {level});
        check_lines(lines);
        CHECK(total_length(lines) ==
              doctest::Approx(length_face_by_face(surface, field, level)).epsilon(1e-9));
      }
    }
  };
  for (const auto& mesh : fixtures::awkward_meshes()) check(mesh.name, mesh.soup, mesh.source);
  for (std::uint32_t number = 0; number < 60; ++number) {
    fixtures::RandomMesh mesh(number);
    check("random mesh " + std::to_string(number), mesh.soup(), mesh.vertex());
  }
}

TEST_CASE("IsolinesOfALargerSurfaceAreLarger") {
  const TriangleSoup soup = shapes::terrain(12, 2, 5);
  const Surface surface(soup);
  const Field field = surface.field_from(70);
  const auto lines = lines_of(surface, field, {3.25});
  for (const int exponent : {-130, 130}) {
    TriangleSoup scaled = soup;
    for (Vec3& p : scaled.positions) p = std::ldexp(1.0, exponent) * p;
    const Surface other(scaled);
    const auto there = lines_of(other, other.field_from(70), {std::ldexp(3.25, exponent)});
    REQUIRE(there.size() == lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i) {
      CHECK(there[i].points.size() == lines[i].points.size());
      CHECK(there[i].closed == lines[i].closed);
      CHECK(std::ldexp(there[i].length, -exponent) ==
            doctest::Approx(lines[i].length).epsilon(1e-12));
    }
  }
}

TEST_CASE("TooManySegmentsAreRefusedWithTheirNumber") {
  const Surface surface(shapes::plane(11, 11));
  const Field field = surface.field_from(0);
  const std::vector<double> levels{3.5, 7.5};
  const auto all = lines_of(surface, field, levels);
  std::uint64_t segments = 0;
  for (const Isoline& line : all) segments += line.points.size() - 1;
  const auto refused = isolines(surface.adjacency(), field, levels, segments - 1, Cancel());
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::too_large);
  CHECK(refused.error().limit == segments - 1);
  CHECK(refused.error().actual == segments);
  CHECK(isolines(surface.adjacency(), field, levels, segments, Cancel()).has_value());
}

TEST_CASE("IsolinesStopWhenCancelled") {
  const Surface surface(shapes::plane(80, 80));
  const Field field = surface.field_from(0);
  const auto stopped =
      isolines(surface.adjacency(), field, std::vector{3.5}, kPlenty, Cancel([] { return true; }));
  REQUIRE_FALSE(stopped);
  CHECK(stopped.error().code == ErrorCode::cancelled);
}
