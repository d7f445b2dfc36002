// Exact distances where a pole is a ring of vertices as far apart as rounding moves them, or a
// little more: against every strip of faces in extended precision.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/fixtures/every_strip.h"
#include "tests/fixtures/modelling_primitives.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Primitive;
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

constexpr double kExact = 1e-9;

// `found` by any way that promises at most the part `above` too much. Where the pole's own ring is
// gone round, rounding is of the whole mesh.
bool is_within(double found, double truth, double above, double extent) {
  if (found == truth) return true;
  const double rounding = kExact * (truth + 1e-6 * extent);
  return found >= truth - rounding && found <= truth * (1 + above) + rounding;
}

// A known fault: out of a vertex that lies on the other side of a needle, some directions are lost
// between two windows, and a path bends where it could be straight. Seen on one lathe in some
// 6,000, as those of 2562770841 + 6 and 3500753743, by `exact` with windows alone.
constexpr double kLostDirections = 1e-3;

struct Way {
  const char* name;
  Method method;
  bool keep_details;
  double tolerance;  // 0: exact

  [[nodiscard]] bool may_lose_directions() const { return method == Method::exact && keep_details; }
};
constexpr std::array kWays{Way{"exact", Method::exact, false, 0},
                           Way{"exact with windows", Method::exact, true, 0},
                           Way{"chen_han", Method::chen_han, false, 0},
                           Way{"chen_han with windows", Method::chen_han, true, 0},
                           Way{"within 1e-3", Method::back_traced, false, 1e-3},
                           Way{"within 0.1", Method::back_traced, false, 0.1}};

Field field_of(const Surface& surface, const Way& way, const Source& source) {
  FieldLimits limits;
  limits.keep_details = way.keep_details;
  MethodOptions options;
  if (way.tolerance > 0) options.error_at_most = way.tolerance;
  constexpr int kMostQuestions = 1000;  // of whether to go on; fewer than ten are asked
  int questions = 0;
  SolveScratch scratch;
  auto field = solve_field(way.method, options, surface.adjacency(), {&source, 1}, limits, scratch,
                           Cancel([&] { return ++questions > kMostQuestions; }));
  REQUIRE_MESSAGE(field, "it does not end");
  return std::move(*field);
}

double extent_of(const Mesh& mesh) { return norm(mesh.box().max - mesh.box().min); }

// A vertex that is in a face, or a point in a face.
Source random_source(Dice& dice, const Surface& surface) {
  const std::uint32_t f = dice.below(surface.mesh().face_count());
  if (dice.below(4) == 0) {
    return {point_on_face(surface.adjacency(), f, {dice.unit(), dice.unit(), dice.unit()}), 0};
  }
  return {point_at_vertex(surface.adjacency(), surface.mesh().faces()[f][dice.below(3)]), 0};
}

// A vertex of the mesh that is farthest up: at a pole, where there is one.
Source top_of(const Surface& surface) {
  const auto positions = surface.mesh().positions();
  std::uint32_t top = surface.mesh().faces()[0][0];
  for (const auto& face : surface.mesh().faces()) {
    for (const std::uint32_t v : face) {
      if (positions[v].z > positions[top].z) top = v;
    }
  }
  return {point_at_vertex(surface.adjacency(), top), 0};
}

// Whether distances by `exact` with windows are too long by what lost directions make them.
bool check_against_every_strip(const TriangleSoup& soup, Dice& dice) {
  const Surface surface(soup);
  const fixtures::EveryStripIn<fixtures::Quad> oracle(surface.adjacency(), 1'000'000);
  if (oracle.gave_up()) return false;
  bool has_lost = false;
  const double extent = extent_of(surface.mesh());
  for (const Source& source :
       {top_of(surface), random_source(dice, surface), random_source(dice, surface)}) {
    const std::vector<double> truth = oracle.distances({source});
    for (const Way& way : kWays) {
      CAPTURE(std::string(way.name));
      CAPTURE(source.point.face);
      CAPTURE(source.point.vertex);
      const Field field = field_of(surface, way, source);
      for (std::uint32_t v = 0; v < truth.size(); ++v) {
        CAPTURE(v);
        CAPTURE(field.distance[v]);
        CAPTURE(truth[v]);
        CAPTURE(field.distance[v] - truth[v]);
        const bool is_right = is_within(field.distance[v], truth[v], way.tolerance, extent);
        has_lost = has_lost || !is_right;
        const bool may_be_lost = way.may_lose_directions() &&
                                 is_within(field.distance[v], truth[v], kLostDirections, extent);
        CHECK((is_right || may_be_lost));
      }
    }
  }
  return has_lost;
}

// A pole as narrow as this is a point in the oracle's digits too.
constexpr double kLeastRing = 1e-25;

// Rings of vertices one above the other, of any radii, the last ones perhaps closed.
TriangleSoup random_lathe(Dice& dice) {
  const std::uint32_t columns = 3 + dice.below(6);
  const std::uint32_t rows = 2 + dice.below(4);
  const double height = dice.below(2) == 0 ? 1 : std::pow(10, 2 * dice.unit() - 1);
  const auto narrow = [&dice] { return std::pow(10, -3 - 17 * dice.unit()); };
  const double waist = dice.below(4) == 0 ? narrow() : 0.3 + dice.unit();
  TriangleSoup soup;
  for (std::uint32_t i = 0; i <= rows; ++i) {
    double radius = 0.3 + dice.unit();
    if (i == 0 || (i == rows && dice.below(2) == 0)) radius = narrow();
    if (2 * i == rows) radius = waist;
    for (std::uint32_t j = 0; j < columns; ++j) {
      const double angle = 2 * std::numbers::pi * (j + 0.2 * i) / columns;
      soup.positions.push_back(
          {radius * std::cos(angle), radius * std::sin(angle), height * i / rows});
    }
  }
  for (std::uint32_t i = 0; i < rows; ++i) {
    for (std::uint32_t j = 0; j < columns; ++j) {
      const std::uint32_t a = i * columns + j;
      const std::uint32_t b = i * columns + (j + 1) % columns;
      const std::uint32_t c = a + columns;
      const std::uint32_t d = b + columns;
      if (dice.below(16) != 0) soup.faces.push_back({a, b, d});
      if (dice.below(16) != 0) soup.faces.push_back({a, d, c});
    }
  }
  // A ring torn apart: needles as thin as it was narrow.
  if (dice.below(4) == 0) {
    for (Vec3& p : soup.positions) p.x += 0.1 * dice.unit();
  }
  if (dice.below(2) == 0) {
    for (std::uint32_t j = 1; j + 1 < columns; ++j) soup.faces.push_back({0, j, j + 1});
  }
  return soup;
}

}  // namespace

TEST_CASE("ExactDistancesHoldOnModellingPrimitivesWithNarrowPoles") {
  const std::uint32_t seed = fixtures::test_seed();
  CAPTURE(seed);
  Dice dice(seed);
  std::uint32_t number = seed % 4;
  for (const Primitive& primitive : fixtures::modelling_primitives(seed)) {
    if (++number % fixtures::all_or(1, 4) != 0) continue;
    if (primitive.pole > 0 && primitive.pole < kLeastRing) continue;
    CAPTURE(fixtures::name_of(primitive));
    CHECK_FALSE(check_against_every_strip(fixtures::soup_of(primitive), dice));
  }
}

TEST_CASE("ExactDistancesHoldOnRandomLathesWithNarrowRings") {
  const std::uint32_t seed = fixtures::test_seed();
  int lost = 0;
  for (std::uint32_t i = 0; i < fixtures::all_or(100, 25); ++i) {
    CAPTURE(seed);
    CAPTURE(i);
    Dice dice(seed + i);
    if (check_against_every_strip(random_lathe(dice), dice)) ++lost;
  }
  CHECK(lost <= 1);
}

// On this one windows went round a ring for ever, each time nearer by rounding, from 8 vertices
// of 24.
TEST_CASE("WindowsDoNotGoRoundRingsForEver") {
  Dice dice(510999358);
  const Surface surface(random_lathe(dice));
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    CAPTURE(v);
    const Source source{point_at_vertex(surface.adjacency(), v), 0};
    for (const Way& way : kWays) {
      CAPTURE(way.name);
      (void)field_of(surface, way, source);
    }
  }
}

// The rows and columns of which programs make theirs; larger than every strip can be unfolded on.
TEST_CASE("APoleAsNarrowAsRoundingIsAPoint") {
  for (const double radius : {1.2246467991473532e-16, 1e-17, 1e-20, 1e-40}) {
    for (const bool float32 : {false, true}) {
      Primitive primitive{fixtures::Solid::uv_sphere, 9, 18, radius};
      primitive.float32 = float32;
      const Surface ring(fixtures::soup_of(primitive));
      primitive.pole = 0;
      const Surface point(fixtures::soup_of(primitive));
      CAPTURE(radius);
      for (const std::uint32_t from : {179U, 166U, 147U, 120U, 40U, 0U}) {
        CAPTURE(from);
        const auto truth = point.in_source_order(field_of(point, kWays[1], {point.at(from), 0}));
        for (const Way& way : kWays) {
          CAPTURE(way.name);
          const auto found = ring.in_source_order(field_of(ring, way, {ring.at(from), 0}));
          for (std::size_t v = 0; v < truth.size(); ++v) {
            CAPTURE(v);
            CAPTURE(found[v]);
            CAPTURE(truth[v]);
            CHECK(is_within(found[v], truth[v], way.tolerance, 2));
          }
        }
      }
    }
  }
}
