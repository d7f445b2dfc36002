// Chen and Han's method against every strip of faces, on random small surfaces of
// every kind that breaks public codes.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/every_strip.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::EveryStrip;
using fixtures::Surface;

namespace {

// Its output is fixed by the standard; distributions' is not.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : engine_(seed) {}
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(engine_() % n); }
  double unit() { return static_cast<double>(engine_()) / 4294967296.0; }

 private:
  std::mt19937 engine_;
};

TriangleSoup noisy_grid(Dice& dice, double height, double shift) {
  TriangleSoup soup =
      shapes::plane(3 + dice.below(2), 3 + dice.below(2),
                    dice.below(2) == 0 ? shapes::Diagonal::rising : shapes::Diagonal::falling);
  for (Vec3& p : soup.positions) {
    p = {p.x + shift * (dice.unit() - 0.5), p.y + shift * (dice.unit() - 0.5),
         height * (dice.unit() - 0.5)};
  }
  return soup;
}

TriangleSoup random_faces(Dice& dice, std::uint32_t vertices, std::uint32_t faces) {
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < vertices; ++i) {
    soup.positions.push_back({dice.unit(), dice.unit(), dice.unit()});
  }
  while (soup.faces.size() < faces) {
    const Triangle t{dice.below(vertices), dice.below(vertices), dice.below(vertices)};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) soup.faces.push_back(t);
  }
  return soup;
}

std::vector<Source> random_sources(Dice& dice, const Surface& surface, std::uint32_t count) {
  std::vector<Source> sources;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double offset = count > 1 ? dice.unit() * (dice.below(2) == 0 ? 1.5 : 0.2) : 0;
    const std::uint32_t kind = dice.below(3);
    if (kind == 0) {
      const std::uint32_t v = dice.below(surface.mesh().vertex_count());
      sources.push_back({point_at_vertex(surface.adjacency(), v), offset});
      continue;
    }
    std::array<double, 3> bary{dice.unit(), dice.unit(), kind == 1 ? 0 : dice.unit()};
    const std::uint32_t f = dice.below(surface.mesh().face_count());
    sources.push_back({point_on_face(surface.adjacency(), f, bary), offset});
  }
  return sources;
}

void check_against_every_strip(Dice& dice, TriangleSoup soup) {
  for (Triangle& t : soup.faces) {
    if (dice.below(3) == 0) std::swap(t[0], t[1]);
  }
  const Surface surface(soup);
  EveryStrip oracle(surface.adjacency());
  for (const std::uint32_t count : {1U, 1U, 2U, 4U}) {
    const auto sources = random_sources(dice, surface, count);
    const Field field = surface.field_by(Method::chen_han, sources);
    const std::vector<double> expected = oracle.distances(sources);
    for (std::size_t v = 0; v < expected.size(); ++v) {
      CAPTURE(v);
      REQUIRE(std::isfinite(field.distance[v]) == std::isfinite(expected[v]));
      if (!std::isfinite(expected[v])) continue;
      REQUIRE(std::abs(field.distance[v] - expected[v]) <= 1e-10 * (1 + expected[v]));
    }
  }
}

}  // namespace

TEST_CASE("ChenHanAgreesWithEveryStrip") {
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    SUBCASE("OnFlatGrids") { check_against_every_strip(dice, noisy_grid(dice, 0, 0)); }
    SUBCASE("OnNoisyGrids") { check_against_every_strip(dice, noisy_grid(dice, 0.6, 0.5)); }
    SUBCASE("OnSteepGrids") { check_against_every_strip(dice, noisy_grid(dice, 2.5, 0.5)); }
    SUBCASE("OnSlivers") {
      TriangleSoup soup = noisy_grid(dice, 1, 0);
      for (Vec3& p : soup.positions) p.x *= 1e-3 * (1 + dice.unit());
      check_against_every_strip(dice, soup);
    }
    SUBCASE("OnTornSheets") {
      TriangleSoup soup = noisy_grid(dice, 1, 0.5);
      TriangleSoup torn{soup.positions, {}};
      for (const Triangle& t : soup.faces) {
        if (torn.faces.empty() || dice.below(3) != 0) torn.faces.push_back(t);
      }
      check_against_every_strip(dice, torn);
    }
    SUBCASE("OnClosedSurfaces") {
      TriangleSoup soup = shapes::icosphere(0);
      for (Vec3& p : soup.positions) p = (0.3 + dice.unit()) * p;
      check_against_every_strip(dice, soup);
    }
    SUBCASE("WhereManyFacesShareEdges") {
      check_against_every_strip(dice, random_faces(dice, 5 + dice.below(3), 4 + dice.below(6)));
    }
    SUBCASE("OnTwoComponents") {
      TriangleSoup soup = noisy_grid(dice, 0.6, 0.5);
      const TriangleSoup other = random_faces(dice, 5, 4);
      const auto first = static_cast<std::uint32_t>(soup.positions.size());
      soup.positions.insert(soup.positions.end(), other.positions.begin(), other.positions.end());
      for (const Triangle& t : other.faces) {
        soup.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
      }
      check_against_every_strip(dice, soup);
    }
  }
}

// Two sources in one face: from the farther one's windows the face beyond the nearer
// one must not be taken away.
TEST_CASE("ChenHanSourcesLieInEachOthersStrips") {
  for (std::uint32_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const Surface surface(noisy_grid(dice, 0.5, 0.5));
    EveryStrip oracle(surface.adjacency());
    std::vector<Source> sources;
    for (int i = 0; i < 4; ++i) {
      sources.push_back(
          {point_on_face(surface.adjacency(), seed % 3, {dice.unit(), dice.unit(), dice.unit()}),
           0.3 * dice.unit()});
    }
    const Field field = surface.field_by(Method::chen_han, sources);
    const std::vector<double> expected = oracle.distances(sources);
    for (std::size_t v = 0; v < expected.size(); ++v) {
      REQUIRE(field.distance[v] == doctest::Approx(expected[v]).epsilon(1e-10));
    }
  }
}
