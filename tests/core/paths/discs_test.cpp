#include "core/paths/discs.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/paths/isolines.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/tube.h"

using namespace geodesic;
using fixtures::Surface;
using fixtures::test_seed;
using std::numbers::pi;

namespace {

std::vector<Disc> discs_of(const Surface& surface, const Field& field,
                           const std::vector<double>& radii) {
  auto found = measure_discs(surface.adjacency(), field, radii, Cancel());
  REQUIRE(found);
  return std::move(found->discs);
}

Disc disc_of(const Surface& surface, const Field& field, double radius) {
  return discs_of(surface, field, {radius}).front();
}

double area_of(const Surface& surface, const Triangle& t) {
  const auto p = surface.mesh().positions();
  return norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])) / 2;
}

bool is_reached(const Field& field, const Triangle& t) {
  return std::all_of(t.begin(), t.end(),
                     [&](std::uint32_t v) { return std::isfinite(field.distance[v]); });
}

// The oracle: each face cut as a polygon in its weights, by the definition.
struct Oracle {
  double area = 0;
  double integral = 0;
  double boundary = 0;
  double growth = 0;  // of the area with the radius
  std::int64_t euler = 0;
  std::uint64_t vertices = 0;
};

using Weights = std::array<double, 3>;

std::vector<Weights> within(const std::array<double, 3>& d, double radius) {
  std::vector<Weights> polygon;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t e = (c + 1) % 3;
    Weights here{};
    here[c] = 1;
    if (d[c] <= radius) polygon.push_back(here);
    if ((d[c] <= radius) == (d[e] <= radius)) continue;
    Weights cut{};
    cut[e] = (radius - d[c]) / (d[e] - d[c]);
    cut[c] = 1 - cut[e];
    polygon.push_back(cut);
  }
  return polygon;
}

Oracle measured(const Surface& surface, const Field& field, double radius) {
  Oracle oracle;
  const auto p = surface.mesh().positions();
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<const Triangle*>> edges;
  std::set<std::uint32_t> in_faces;
  for (const Triangle& t : surface.mesh().faces()) {
    for (std::size_t c = 0; c < 3; ++c) {
      in_faces.insert(t[c]);
      edges[std::minmax(t[c], t[(c + 1) % 3])].push_back(&t);
    }
    if (!is_reached(field, t)) continue;
    const std::array<double, 3> d{field.distance[t[0]], field.distance[t[1]], field.distance[t[2]]};
    const double area = area_of(surface, t);
    const std::vector<Weights> polygon = within(d, radius);
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      const Weights& a = polygon[0];
      const Weights& b = polygon[i - 1];
      const Weights& c = polygon[i];
      const double part = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) sum += d[k] * (a[k] + b[k] + c[k]);
      oracle.area += std::abs(part) * area;
      oracle.integral += std::abs(part) * area * sum / 3;
    }
    if (*std::max_element(d.begin(), d.end()) <= radius) ++oracle.euler;
    // Twice the area times the slope is the length of d's gradient turned by a right angle.
    Vec3 slope{};
    Vec3 ends[2];
    std::size_t count = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t e = (c + 1) % 3;
      slope = slope + d[(c + 2) % 3] * (p[t[e]] - p[t[c]]);
      if ((d[c] < radius) == (d[e] < radius)) continue;
      const double part = (radius - d[c]) / (d[e] - d[c]);
      if (count < 2) ends[count++] = (1 - part) * p[t[c]] + part * p[t[e]];
    }
    if (count == 2 && area > 0)
      oracle.growth += distance(ends[0], ends[1]) * 2 * area / norm(slope);
  }
  for (const auto& [edge, faces] : edges) {
    const double a = std::min(field.distance[edge.first], field.distance[edge.second]);
    const double b = std::max(field.distance[edge.first], field.distance[edge.second]);
    if (b <= radius) --oracle.euler;
    if (faces.size() != 1 || !is_reached(field, *faces[0])) continue;
    const double length = distance(p[edge.first], p[edge.second]);
    if (b <= radius) {
      const auto is_below = [&](std::uint32_t v) { return field.distance[v] < radius; };
      const bool is_line = a == radius && std::any_of(faces[0]->begin(), faces[0]->end(), is_below);
      oracle.boundary += is_line ? 0 : length;
    } else if (a < radius) {
      oracle.boundary += length * (radius - a) / (b - a);
    }
  }
  for (const std::uint32_t v : in_faces) {
    if (field.distance[v] <= radius) ++oracle.euler;
  }
  for (const std::uint32_t v : surface.mesh().vertex_of_source()) {
    if (field.distance[v] <= radius) ++oracle.vertices;
  }
  return oracle;
}

// Against the oracle and the isolines, at radii that are vertices' distances and such as are none.
void check_discs(const Surface& surface, const Field& field, std::mt19937& random) {
  std::vector<double> radii{0, field.max};
  for (int i = 0; i < 12; ++i) {
    radii.push_back(1.1 * field.max * (random() / 4294967296.0));
    const double there = field.distance[random() % surface.mesh().vertex_count()];
    if (std::isfinite(there)) radii.push_back(there);
  }
  std::sort(radii.begin(), radii.end());
  radii.erase(std::unique(radii.begin(), radii.end()), radii.end());
  const std::vector<Disc> discs = discs_of(surface, field, radii);
  REQUIRE(discs.size() == radii.size());
  double whole = 0;
  for (const Triangle& t : surface.mesh().faces()) {
    if (is_reached(field, t)) whole += area_of(surface, t);
  }
  const auto lines = isolines(surface.adjacency(), field, radii, 10'000'000, Cancel());
  REQUIRE(lines);
  const double small = 1e-9 * whole;
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const Disc& disc = discs[i];
    CAPTURE(disc.radius);
    const Oracle oracle = measured(surface, field, radii[i]);
    CHECK(disc.radius == radii[i]);
    CHECK(std::abs(disc.area - oracle.area) <= small);
    CHECK(std::abs(disc.mean * disc.area - oracle.integral) <= small * field.max);
    CHECK(disc.boundary == doctest::Approx(oracle.boundary).epsilon(1e-9));
    CHECK(disc.euler == oracle.euler);
    CHECK(disc.vertices == oracle.vertices);
    double length = 0;
    std::uint64_t count = 0;
    for (const Isoline& line : *lines) {
      if (line.level != radii[i]) continue;
      length += line.length;
      ++count;
    }
    CHECK(disc.perimeter == doctest::Approx(length).epsilon(1e-12));
    CHECK(disc.lines == count);
    if (i > 0) CHECK(disc.area >= discs[i - 1].area * (1 - 1e-12));
    if (i > 0) CHECK(disc.vertices >= discs[i - 1].vertices);
    if (disc.radius >= field.max) CHECK(std::abs(disc.area - whole) <= 1e-12 * whole);
  }
}

}  // namespace

TEST_CASE("DiscsOfAPlaneAreThoseOfEuclidAndTheErrorFallsWithTheSquareOfTheEdges") {
  double area_before = 0;
  double perimeter_before = 0;
  double mean_before = 0;
  for (const std::uint32_t half : {10U, 20U, 40U, 80U}) {
    const std::uint32_t side = 2 * half + 1;
    const Surface surface(shapes::plane(side, side));
    const Field field =
        surface.field_by(Method::exact, {Source{surface.at(half * side + half), 0}});
    const double radius = 0.7123 * half;
    const Disc disc = disc_of(surface, field, radius);
    const double area = std::abs(disc.area / (pi * radius * radius) - 1);
    const double perimeter = std::abs(disc.perimeter / (2 * pi * radius) - 1);
    const double mean = std::abs(disc.mean / (2 * radius / 3) - 1);
    CHECK(area < 0.01);
    CHECK(perimeter < 0.01);
    CHECK(mean < 0.01);
    CHECK(disc.lines == 1);
    CHECK(disc.euler == 1);
    CHECK(disc.boundary == 0);
    CHECK_FALSE(disc.is_whole);
    if (area_before != 0) {
      CHECK(area < area_before / 3);
      CHECK(perimeter < perimeter_before / 3);
      CHECK(mean < mean_before / 3);
    }
    area_before = area;
    perimeter_before = perimeter;
    mean_before = mean;
  }
}

TEST_CASE("DiscsOfASphereAreCaps") {
  double before = 0;
  for (const std::uint32_t levels : {3U, 4U, 5U}) {
    const Surface surface(shapes::icosphere(levels));
    const Field field = surface.field_by(Method::exact, {Source{surface.at(0), 0}});
    double worst = 0;
    for (const Disc& disc : discs_of(surface, field, {0.4, 1.0, pi / 2, 2.5})) {
      worst = std::max(worst, std::abs(disc.area / (2 * pi * (1 - std::cos(disc.radius))) - 1));
      worst = std::max(worst, std::abs(disc.perimeter / (2 * pi * std::sin(disc.radius)) - 1));
      CHECK(disc.lines == 1);
      CHECK(disc.euler == 1);
    }
    CHECK(worst < 0.05);
    if (before != 0) CHECK(worst < before / 2.5);
    before = worst;
    const Disc whole = disc_of(surface, field, field.max);
    CHECK(whole.is_whole);
    CHECK(whole.euler == 2);
    CHECK(whole.area == doctest::Approx(surface.mesh().area()).epsilon(1e-12));
    CHECK(whole.mean == doctest::Approx(pi / 2).epsilon(0.01));
  }
}

// Unrolled, the cylinder is a band of width 2 pi, and what is nearest stands across from it.
TEST_CASE("DiscsOfACylinderAreThoseOfItsUnrolledBand") {
  const std::uint32_t columns = 120;
  const std::uint32_t rows = 200;
  const Surface surface(fixtures::tube(columns, rows * 2 * pi / columns, rows));
  const Field field = surface.field_by(Method::exact, {Source{surface.at(columns * rows / 2), 0}});
  const auto discs = discs_of(surface, field, {1, 3, 4, 6});
  const double height = rows * 2 * pi / columns / 2;  // above the source, and below
  CHECK(discs[0].area == doctest::Approx(pi).epsilon(0.004));
  CHECK(discs[1].area == doctest::Approx(9 * pi).epsilon(0.004));
  CHECK(discs[1].perimeter == doctest::Approx(6 * pi).epsilon(0.004));
  CHECK(discs[1].euler == 1);
  // Twice the integral of sqrt(r^2 - x^2) over the band.
  const auto band = [](double r) {
    return 2 * (pi * std::sqrt(r * r - pi * pi) + r * r * std::asin(pi / r));
  };
  CHECK(discs[2].area == doctest::Approx(band(4)).epsilon(0.004));
  CHECK(discs[2].perimeter == doctest::Approx(2 * 2 * 4 * std::asin(pi / 4)).epsilon(0.004));
  CHECK(discs[2].lines == 2);
  CHECK(discs[2].euler == 0);
  CHECK(discs[2].boundary == 0);
  // It comes to both ends: what is beyond them is cut off, and each end has its part.
  const double half_chord = std::sqrt(6 * 6 - height * height);
  REQUIRE(height < 6);
  REQUIRE(half_chord < pi);
  CHECK(discs[3].boundary == doctest::Approx(4 * half_chord).epsilon(0.01));
}

TEST_CASE("DiscsAreWhatTheLinearFieldSays") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 40; ++i) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const auto some = [&] {
      return surface.at(
          static_cast<std::uint32_t>(random() % surface.mesh().source_vertex_count()));
    };
    std::vector<Source> sources{{some(), 0}};
    if (i % 3 == 1) sources.push_back({some(), 0.3});
    const Method methods[] = {Method::exact, Method::back_traced, Method::dijkstra};
    check_discs(surface, surface.field_by(methods[random() % 3], sources), random);
  }
}

TEST_CASE("DiscsOfAwkwardSurfacesAreWhatTheLinearFieldSays") {
  std::mt19937 random(test_seed());
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    for (const Method method : {Method::exact, Method::dijkstra}) {
      const auto v = static_cast<std::uint32_t>(random() % surface.mesh().source_vertex_count());
      CAPTURE(v);
      check_discs(surface, surface.field_by(method, {{surface.at(v), 0}}), random);
    }
  }
}

// A disc grows by its isoline, over the slope of the field there: the coarea formula.
TEST_CASE("AreasGrowByTheirIsolines") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 30; ++i) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const Field field = surface.field_from(
        static_cast<std::uint32_t>(random() % surface.mesh().source_vertex_count()));
    // Between two vertices' distances the area is a square of the radius: differences are exact.
    std::vector<double> distances = surface.in_source_order(field);
    std::sort(distances.begin(), distances.end());
    std::size_t at = random() % (distances.size() - 1);
    while (at > 0 && distances[at + 1] - distances[at] < 1e-4 * field.max) --at;
    if (at == 0 || !std::isfinite(distances[at + 1])) continue;
    const double step = (distances[at + 1] - distances[at]) / 4;
    const double radius = distances[at] + 2 * step;
    const auto discs = discs_of(surface, field, {radius - step, radius + step});
    const double growth = (discs[1].area - discs[0].area) / (2 * step);
    CHECK(growth == doctest::Approx(measured(surface, field, radius).growth).epsilon(1e-6));
  }
}

TEST_CASE("WithoutASourceOnAComponentNoDiscIsWhole") {
  TriangleSoup soup = shapes::plane(4, 4);
  const TriangleSoup other = soup;
  for (Vec3 p : other.positions) soup.positions.push_back(p + Vec3{9, 0, 0});
  for (const auto& t : other.faces) soup.faces.push_back({t[0] + 16, t[1] + 16, t[2] + 16});
  const Surface surface(soup);
  const Disc disc = disc_of(surface, surface.field_from(0), 100);
  CHECK(disc.area == doctest::Approx(9));
  CHECK(disc.boundary == doctest::Approx(12));
  CHECK(disc.vertices == 16);
  CHECK(disc.euler == 1);
  CHECK(disc.perimeter == 0);
  CHECK_FALSE(disc.is_whole);
}

TEST_CASE("NoRadiusNoDisc") {
  const Surface surface(shapes::plane(4, 4));
  CHECK(discs_of(surface, surface.field_from(0), {}).empty());
}

TEST_CASE("DiscsAreStoppedInTheMiddle") {
  const Surface surface(shapes::icosphere(5));
  const Field field = surface.field_from(3);
  std::vector<double> radii;
  for (int i = 1; i <= 200; ++i) radii.push_back(field.max * i / 201);
  for (const std::size_t most : {0U, 3U, 12U}) {
    std::size_t asked = 0;
    const Cancel counting([&] { return ++asked > most; });
    const auto discs = measure_discs(surface.adjacency(), field, radii, counting);
    REQUIRE_FALSE(discs.has_value());
    CHECK(discs.error().code == ErrorCode::cancelled);
  }
}
