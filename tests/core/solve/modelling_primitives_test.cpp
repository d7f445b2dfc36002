// The solids of modelling programs, whose poles are rings as wide as rounding: everything
// that goes over them comes to an end, and what it says is so.
#include "tests/fixtures/modelling_primitives.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/paths/isolines.h"
#include "core/paths/trace_path.h"
#include "core/solve/solve_field.h"
#include "core/straighten/refine_path.h"
#include "core/straighten/straightest_geodesic.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Primitive;
using fixtures::Solid;
using fixtures::Surface;

TEST_CASE("ModellingPrimitivesHaveThePolesThatTheyName") {
  for (const Primitive& primitive : fixtures::modelling_primitives(fixtures::test_seed())) {
    CAPTURE(fixtures::name_of(primitive));
    const TriangleSoup soup = fixtures::soup_of(primitive);
    const Surface surface(soup);
    CHECK(surface.mesh().vertex_count() >= 4);
    CHECK(surface.mesh().vertex_count() <= 120);
    if (primitive.solid == Solid::icosphere) continue;
    double nearest = kUnreached;  // to the axis, of the vertices that are not on it
    for (const Vec3 p : soup.positions) {
      if (const double r = std::hypot(p.x, p.y); r > 0) nearest = std::min(nearest, r);
    }
    const double rounding = primitive.float32 ? 1e-5 : 1e-12;
    if (primitive.pole > 0) {
      CHECK(std::abs(nearest - primitive.pole) <= rounding * primitive.pole);
    } else {
      CHECK(nearest > 1e-3);
    }
  }
}

namespace {

// Fewer solids where each takes ten times as long.
constexpr std::uint32_t kOneIn = fixtures::all_or(1, 8);

// What is asked more often than this works on a few faces without end.
constexpr int kMostQuestions = 20'000;
Cancel soon() {
  return Cancel([asked = 0]() mutable { return ++asked > kMostQuestions; });
}

bool is_exact(Method method) { return method == Method::exact || method == Method::chen_han; }

struct NamedMethod {
  const char* name;
  Method method;
  MethodOptions options;
};

std::vector<NamedMethod> every_method() {
  std::vector<NamedMethod> methods{
      {"exact", Method::exact, {}},         {"chen_han", Method::chen_han, {}},
      {"auto", Method::back_traced, {}},    {"upper", Method::back_traced, {}},
      {"wavefront", Method::wavefront, {}}, {"novotni", Method::novotni, {}},
      {"dijkstra", Method::dijkstra, {}},   {"fast_marching", Method::fast_marching, {}},
      {"steiner", Method::steiner, {}}};
  methods[3].options.bound = Bound::upper;
  return methods;
}

// All questions to one solid.
class Inquiry {
 public:
  explicit Inquiry(const Primitive& primitive)
      : soup_(fixtures::soup_of(primitive)),
        surface_(soup_),
        size_(distance(surface_.mesh().box().min, surface_.mesh().box().max)) {}

  void check(std::uint32_t sources, std::mt19937& random) {
    const std::uint32_t count = surface_.mesh().vertex_count();
    for (std::uint32_t i = 0; i < sources; ++i) {
      // Poles first: those at the ends of the rows, then any.
      const std::uint32_t v = i == 0   ? surface_.vertex(std::uint32_t(soup_.positions.size()) - 1)
                              : i == 1 ? surface_.vertex(0)
                                       : std::uint32_t(random()) % count;
      CAPTURE(surface_.mesh().source_of_vertex(v));
      std::vector<double> truth;  // by the first of them, `exact`
      for (const NamedMethod& named : every_method()) {
        CAPTURE(std::string(named.name));
        check_from(v, named, truth);
      }
      check_straightest(v);
    }
  }

 private:
  void check_from(std::uint32_t from, const NamedMethod& named, std::vector<double>& truth) {
    const Adjacency& adjacency = surface_.adjacency();
    const Source source{point_at_vertex(adjacency, from), 0};
    auto field =
        solve_field(named.method, named.options, adjacency, {&source, 1}, {}, scratch_, soon());
    REQUIRE(field.has_value());
    for (std::uint32_t v = 0; v < surface_.mesh().vertex_count(); ++v) {
      CAPTURE(surface_.mesh().source_of_vertex(v));
      if (named.method == Method::exact) truth.push_back(field->distance[v]);
      if (is_exact(named.method) && truth[v] != kUnreached) {
        REQUIRE(std::abs(field->distance[v] - truth[v]) <= 1e-9 * truth[v] + 1e-14 * size_);
      }
      check_path(*field, from, v, truth[v]);
    }
    const std::vector<double> levels{1e-16, 1e-8, 0.3, 0.7, 1.1, 2};
    REQUIRE(isolines(adjacency, *field, levels, 1'000'000, soon()).has_value());
  }

  void check_path(const Field& field, std::uint32_t from, std::uint32_t to, double truth) {
    const Adjacency& adjacency = surface_.adjacency();
    const double d = field.distance[to];
    const SurfacePoint target = point_at_vertex(adjacency, to);
    const auto traced = trace_path(adjacency, field, target, soon());
    REQUIRE(traced.has_value());
    REQUIRE(traced->has_value() == (d != kUnreached));
    if (d == kUnreached) return;
    const Path& path = **traced;
    const double straight =
        distance(surface_.mesh().positions()[from], surface_.mesh().positions()[to]);
    // No path is shorter than the shortest.
    REQUIRE(path.length >= truth * (1 - 1e-9) - 1e-14 * size_);
    REQUIRE(path.length >= straight * (1 - 1e-12) - 1e-15 * size_);
    if (is_exact(field.method)) {
      REQUIRE(std::abs(path.length - d) <= 1e-9 * d + 1e-14 * size_);
    }
    REQUIRE(path.points.front().point.vertex == from);
    REQUIRE(path.points.back().point.vertex == to);
    fixtures::check_is_a_path(adjacency, path, size_);
    const auto refined = refine_path(adjacency, field, target, path, soon());
    REQUIRE(refined.has_value());
    REQUIRE(refined->length <= path.length);
    REQUIRE(refined->length >= truth * (1 - 1e-9) - 1e-14 * size_);
  }

  void check_straightest(std::uint32_t from) {
    const SurfacePoint start = point_at_vertex(surface_.adjacency(), from);
    if (start.face == kNone) return;
    for (const double angle : {0.0, 0.4, 1.3, 2.9}) {
      const auto line =
          straightest_geodesic_at_angle(surface_.adjacency(), start, angle, 5, soon());
      // Where the fan ends at a boundary there may be no such angle.
      if (!line) {
        REQUIRE(line.error().code == ErrorCode::value_out_of_range);
        continue;
      }
      REQUIRE(line->path.length <= 5 * (1 + 1e-9));
    }
  }

  TriangleSoup soup_;
  Surface surface_;
  double size_;
  SolveScratch scratch_;
};

}  // namespace

TEST_CASE("EverythingOverModellingPrimitivesComesToAnEnd") {
  const std::uint32_t seed = fixtures::test_seed();
  std::mt19937 random(seed);
  std::uint32_t number = seed;
  for (const Primitive& primitive : fixtures::modelling_primitives(seed)) {
    if (++number % kOneIn != 0) continue;
    CAPTURE(fixtures::name_of(primitive));
    Inquiry(primitive).check(4, random);
  }
}

// Columns whose last ring, which has no lid, is as narrow as rounding: a path to one of its
// vertices went round among them for ever.
TEST_CASE("PathsToSevenFacesAtAPoleEnd") {
  const Surface surface(
      {{{.9, 0, .5},
        {.9, 0, -.5},
        {.4, .8, -.5},
        {-.4, .8, -.5},
        {.4, -.8, -.5},
        {1e-16, 0, -1},
        {6e-17, 1e-16, -1},
        {-6e-17, 1e-16, -1},
        {6e-17, -1e-16, -1}},
       {{0, 4, 1}, {1, 5, 2}, {2, 5, 6}, {2, 6, 3}, {3, 6, 7}, {4, 8, 1}, {1, 8, 5}}});
  for (const Method method : {Method::exact, Method::chen_han}) {
    for (std::uint32_t from = 0; from < 9; ++from) {
      const Field field = surface.field_by(method, {Source{surface.at(from), 0}});
      for (std::uint32_t to = 0; to < 9; ++to) {
        const auto path = trace_path(surface.adjacency(), field, surface.at(to), soon());
        REQUIRE(path.has_value());
        REQUIRE(path->has_value());
        const double d = field.distance[surface.vertex(to)];
        CHECK(std::abs((*path)->length - d) <= 1e-12 * d + 1e-15);
      }
    }
  }
}

// As modelling programs write them, in the sizes that they offer first.
TEST_CASE("PathsToThePolesOfUvSpheresAreAsLongAsTheirDistances") {
  for (const auto& [rows, columns] : {std::pair{3U, 6U}, {4U, 8U}, {8U, 12U}, {9U, 18U}}) {
    for (const bool float32 : {false, true}) {
      Primitive primitive;
      primitive.rows = rows;
      primitive.columns = columns;
      primitive.pole = 1.2246467991473532e-16;
      primitive.float32 = float32;
      CAPTURE(fixtures::name_of(primitive));
      const Surface surface(fixtures::soup_of(primitive));
      const std::uint32_t count = (rows + 1) * columns;
      for (const Method method : {Method::exact, Method::chen_han}) {
        for (std::uint32_t from = 0; from < count; from += 5 * kOneIn) {
          CAPTURE(from);
          const Field field = surface.field_by(method, {Source{surface.at(from), 0}});
          for (std::uint32_t to = 0; to < count; ++to) {
            CAPTURE(to);
            const auto path = trace_path(surface.adjacency(), field, surface.at(to), soon());
            REQUIRE(path.has_value());
            REQUIRE(path->has_value());
            const double d = field.distance[surface.vertex(to)];
            REQUIRE(std::abs((*path)->length - d) <= 1e-12 * d + 1e-15);
          }
        }
      }
    }
  }
}
