// Where faces have no area, or hardly any, there are ways along edges at least; and no method's
// answer is worse.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/exact_strips.h"
#include "tests/fixtures/mixed_scales.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

struct FlatMethod {
  std::string name;
  Method method;
  Bound bound = Bound::none;
  double tolerance = -1;  // none
};

const FlatMethod kFlatMethods[] = {{"wavefront", Method::wavefront},
                                   {"novotni", Method::novotni},
                                   {"dijkstra", Method::dijkstra},
                                   {"fast_marching", Method::fast_marching},
                                   {"steiner", Method::steiner},
                                   {"auto", Method::back_traced},
                                   {"upper", Method::back_traced, Bound::upper},
                                   {"within 0.01", Method::back_traced, Bound::none, 0.01},
                                   {"exact", Method::exact},
                                   {"chen_han", Method::chen_han}};

MethodOptions options_of(const FlatMethod& by) {
  MethodOptions options;
  options.bound = by.bound;
  if (by.tolerance >= 0) options.error_at_most = by.tolerance;
  return options;
}

void check_as_near_as_along_edges(const Surface& surface, std::uint32_t from) {
  constexpr int kMostQuestions = 300;  // of whether to go on; some 50 are asked
  const Source source{point_at_vertex(surface.adjacency(), from), 0};
  const Field edges = surface.field_by(Method::dijkstra, {source});
  // Windows and nodes lie on edges, where places are rounded as coarsely as those are long; and
  // the shapes of faces tell their heights as coarsely.
  const Box& box = surface.mesh().box();
  const double of_places = 1e-14 * norm(box.max - box.min);
  for (const FlatMethod& by : kFlatMethods) {
    CAPTURE(by.name);
    // Its windows are too many to wait for on some such heaps.
    if (by.method == Method::chen_han) continue;
    const bool by_windows = by.method == Method::exact || by.tolerance >= 0;
    int questions = 0;
    SolveScratch scratch;
    const auto solved =
        solve_field(by.method, options_of(by), surface.adjacency(), {&source, 1}, {}, scratch,
                    Cancel([&] { return ++questions > kMostQuestions; }));
    REQUIRE_MESSAGE(solved, "it does not end");
    const Field& field = *solved;
    // These go by the shapes of faces, in which a short side beside long ones is not exact.
    const bool by_shapes = by.method == Method::fast_marching || by.method == Method::steiner;
    const double rounding = by_windows || by_shapes ? of_places : 0;
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      CAPTURE(edges.distance[v]);
      if (edges.distance[v] == kUnreached) {
        CHECK(field.distance[v] == kUnreached);
        continue;
      }
      const double slack = by_shapes ? 1e-3 : 1e-6;
      CHECK(field.distance[v] <= edges.distance[v] * (1 + slack) + rounding);
      const Vec3 from_there = surface.mesh().positions()[v] - surface.mesh().positions()[from];
      CHECK(field.distance[v] >= norm(from_there) * (1 - 1e-6) - rounding);
    }
  }
}

}  // namespace

TEST_CASE("OfPointsOnALineNoMethodIsWorseThanEdges") {
  std::mt19937 random(fixtures::test_seed());
  for (const double off : {0.0, 1e-300, 1e-100, 1e-30, 1e-16, 1e-12, 1e-8}) {
    CAPTURE(off);
    for (int round = 0; round < 25; ++round) {
      CAPTURE(round);
      const TriangleSoup soup = fixtures::heap_on_a_line(random, off);
      if (!Mesh::build(soup)) continue;  // all faces without two distinct points
      const Surface surface(soup);
      check_as_near_as_along_edges(surface, random() % surface.mesh().vertex_count());
    }
  }
}

// From points that rounding alone moves off the line to thin faces.
TEST_CASE("OfPointsNearlyOnALineNoMethodIsWorseThanEdgesOrBelowTheStraightLine") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < 150; ++round) {
    const double off = fixtures::any_scale(random, -16, -7);
    CAPTURE(round);
    CAPTURE(off);
    // Points lie as far off it as along a unit of it.
    const TriangleSoup soup = fixtures::heap_on_a_line(random, 40 * off);
    if (!Mesh::build(soup)) continue;
    const Surface surface(soup);
    check_as_near_as_along_edges(surface, random() % surface.mesh().vertex_count());
  }
}

// Against 113 bits, what promises to be exact or not below; strips of faces, which end.
TEST_CASE("OnStripsNearlyOnALineExactIsExactAndUpperIsAbove") {
  std::mt19937 random(fixtures::test_seed());
  int compared = 0;
  for (int round = 0; round < 200; ++round) {
    CAPTURE(round);
    TriangleSoup soup;
    const double off = fixtures::any_scale(random, -16, -7);
    const int count = 5 + static_cast<int>(random() % 10);
    for (int i = 0; i < count; ++i) {
      soup.positions.push_back({fixtures::fraction(random), off * fixtures::fraction(random),
                                off * fixtures::fraction(random)});
    }
    for (std::uint32_t i = 0; i + 2 < soup.positions.size(); ++i) {
      soup.faces.push_back({i, i + 1, i + 2});
    }
    const Surface surface(soup);
    const fixtures::ExactStrips strips(surface.adjacency());
    if (!strips.complete()) continue;
    ++compared;
    const std::uint32_t from = random() % surface.mesh().vertex_count();
    const std::vector<double> truth = strips.distances(from);
    const Source source{point_at_vertex(surface.adjacency(), from), 0};
    for (const FlatMethod& by : kFlatMethods) {
      const bool is_exact = by.method == Method::exact || by.method == Method::chen_han;
      if (!is_exact && by.bound != Bound::upper && by.tolerance < 0) continue;
      CAPTURE(by.name);
      const Field field = surface.field_by(by.method, {source}, {}, options_of(by));
      for (std::uint32_t v = 0; v < truth.size(); ++v) {
        CAPTURE(v);
        CAPTURE(truth[v]);
        // Windows lie on edges of a length of up to one.
        CHECK(field.distance[v] >= truth[v] * (1 - 1e-9) - 1e-12);
        if (is_exact) CHECK(field.distance[v] <= truth[v] * (1 + 1e-9) + 1e-12);
        if (by.tolerance >= 0) {
          CHECK(field.distance[v] <= truth[v] * (1 + by.tolerance) + 1e-12);
        }
      }
    }
  }
  CHECK(compared > 150);
}

TEST_CASE("OfPointsAllInOnePlaceButOneNoMethodIsWorseThanEdges") {
  for (const double apart : {0.0, 1e-300, 1e-30, 1e-16, 1e-12}) {
    CAPTURE(apart);
    TriangleSoup soup;
    for (int i = 0; i < 12; ++i) {
      soup.positions.push_back({apart * std::cos(i), apart * std::sin(2 * i), apart * i});
    }
    soup.positions.push_back({3, 4, 0});
    for (std::uint32_t i = 0; i < 11; ++i) soup.faces.push_back({i, i + 1, 12});
    if (!Mesh::build(soup)) continue;
    const Surface surface(soup);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      check_as_near_as_along_edges(surface, v);
    }
  }
}

// A way over a face that is a line turns where the face ends, and does not lead back as if it went
// on. So no bound is below the way by windows, whether chen_han's or exact's.
TEST_CASE("OverFacesFoldedOnALineUpperIsNotBelowTheTruth") {
  std::mt19937 random(fixtures::test_seed());
  const Surface behind(
      {{{0, 0, -3.875}, {0, 0, -3.625}, {0, 0, -3.25}, {0, 0, 0}}, {{3, 1, 0}, {0, 1, 2}}});
  const Surface before({{{0, 0, 2}, {0, 0, -2}, {0, 0, 1}, {0, 0, 0}, {1, 0, 1}},
                        {{0, 1, 2}, {1, 0, 2}, {2, 3, 4}, {0, 2, 3}, {0, 3, 2}}});
  MethodOptions upper;
  upper.bound = Bound::upper;
  for (const auto& [method, options] :
       {std::pair{Method::back_traced, upper}, std::pair{Method::back_traced, MethodOptions()},
        std::pair{Method::wavefront, MethodOptions()}}) {
    CAPTURE(static_cast<int>(method));
    const Field over_behind = behind.field_by(method, {{behind.at(3), 0}}, {}, options);
    CHECK(over_behind.distance[behind.vertex(2)] == doctest::Approx(4.0));
    const Field over_before =
        before.field_by(method, {{before.on(0, {0.5, 0.4, 0.1}), 0}}, {}, options);
    CHECK(over_before.distance[before.vertex(3)] == doctest::Approx(1.7));
  }
  int compared = 0;
  for (int round = 0; round < 300; ++round) {
    CAPTURE(round);
    TriangleSoup soup = fixtures::grown(random, 3 + static_cast<int>(random() % 25));
    const bool turned = random() % 2 == 0;
    for (Vec3& p : soup.positions) {
      p = {std::round(2 * p.x) + std::round(p.y), 0,
           round % 3 == 0 && p.z > 0.5 ? std::round(p.z) : 0.0};
      if (turned) p = {0.6 * p.x, 0.8 * p.x, p.z};
    }
    if (!Mesh::build(soup)) continue;
    const Surface surface(soup);
    const auto face = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    const auto vertex = static_cast<std::uint32_t>(random() % surface.mesh().vertex_count());
    const Source source{random() % 2 == 0
                            ? point_on_face(surface.adjacency(), face, {0.5, 0.3, 0.2})
                            : point_at_vertex(surface.adjacency(), vertex),
                        0};
    const auto solved = [&](Method method) {
      int questions = 0;
      SolveScratch scratch;
      return solve_field(method, {}, surface.adjacency(), {&source, 1}, {}, scratch,
                         Cancel([&] { return ++questions > 300; }));
    };
    const auto exact = solved(Method::exact);
    const auto chen_han = solved(Method::chen_han);
    if (!exact || !chen_han) continue;
    ++compared;
    const Field bound = surface.field_by(Method::back_traced, {source}, {}, upper);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      if (exact->distance[v] == kUnreached) continue;
      const double truth = std::min(exact->distance[v], chen_han->distance[v]);
      CHECK(bound.distance[v] >= truth * (1 - 1e-9));
    }
  }
  CHECK(compared > 200);
}
