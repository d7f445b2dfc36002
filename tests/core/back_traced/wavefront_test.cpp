#include "core/back_traced/wavefront.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/straighten/shorten_path.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;

namespace {

Field back_traced(const Surface& surface, const std::vector<Source>& sources,
                  Bound bound = Bound::none, const FieldLimits& limits = {}) {
  MethodOptions options;
  options.bound = bound;
  return surface.field_by(Method::back_traced, sources, limits, options);
}

struct Errors {
  double mean = 0;
  double above = 0;
  double below = 0;
};

Errors errors_from(const Field& field, const Field& truth) {
  Errors off;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < truth.distance.size(); ++v) {
    REQUIRE((field.distance[v] == kUnreached) == (truth.distance[v] == kUnreached));
    if (truth.distance[v] == kUnreached || truth.distance[v] == 0) continue;
    const double error = field.distance[v] / truth.distance[v] - 1;
    off.above = std::max(off.above, error);
    off.below = std::min(off.below, error);
    sum += std::abs(error);
    ++count;
  }
  off.mean = sum / static_cast<double>(std::max<std::size_t>(count, 1));
  return off;
}

TriangleSoup long_and_thin(TriangleSoup soup, double factor) {
  for (Vec3& p : soup.positions) p.x *= factor;
  return soup;
}

}  // namespace

TEST_CASE("LookingBackIsTenTimesAsExactAsThePapersFront") {
  const struct {
    std::string name;
    TriangleSoup soup;
    double mean;
    double most;
  } cases[] = {
      {"a sphere", shapes::icosphere(4), 5e-4, 5e-3},
      {"a terrain", shapes::terrain(60, 12, 3), 3e-4, 3e-2},
      {"a terrain, stretched", long_and_thin(shapes::terrain(60, 6, 3), 8), 3e-4, 1e-2},
      {"a saddle", shapes::saddle(40, 12), 1e-3, 1e-2},
      {"a knot", shapes::torus_knot(150, 12, 0.4), 1e-3, 1e-2},
  };
  for (const auto& [name, soup, mean, most] : cases) {
    CAPTURE(name);
    const Surface surface(soup);
    for (const std::uint32_t from : {0U, 77U, 1000U}) {
      const std::vector<Source> source{{surface.at(from), 0}};
      const Field truth = surface.field_by(Method::exact, source);
      const Errors paper = errors_from(surface.field(source), truth);
      const Errors looking_back = errors_from(back_traced(surface, source), truth);
      MESSAGE(name, ": mean ", looking_back.mean, ", above ", looking_back.above, ", below ",
              looking_back.below, "; the paper's mean ", paper.mean);
      CHECK(looking_back.mean <= mean);
      CHECK(looking_back.above <= most);
      CHECK(looking_back.below >= -most);
      CHECK(looking_back.mean < paper.mean / 2);
    }
  }
}

// Where faces are not obtuse, which those at the border stay, two circles never err.
TEST_CASE("OnAPlaneNearlyAllDistancesAreStraightLinesToTheLastBitsOfAFloat") {
  constexpr double kRounding = 6e-8;  // half a step of floats
  for (const double stretch : {1.0, 8.0}) {
    CAPTURE(stretch);
    const Surface surface(long_and_thin(shapes::terrain(50, 0, 8), stretch));
    for (const Bound bound : {Bound::none, Bound::upper}) {
      const auto at = surface.at(1234);
      const Field field = back_traced(surface, {{at, 0}}, bound);
      std::size_t exact = 0;
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        const double straight =
            distance(surface.mesh().positions()[v], surface.mesh().positions()[at.vertex]);
        const double off = straight > 0 ? field.distance[v] / straight - 1 : 0;
        CHECK(off >= (bound == Bound::upper ? -1e-12 : -kRounding));
        CHECK(off <= 1e-2);
        if (straight < 5) CHECK(off <= 2 * kRounding);  // in sight of the source
        if (off <= kRounding) ++exact;
      }
      if (bound == Bound::none) CHECK(exact >= (stretch == 1 ? 2450 : 1900));
    }
  }
}

// Where faces are much finer than elsewhere, a round of many vertices must not pass over
// what lies between them.
TEST_CASE("FinerFacesInACornerAreAsExact") {
  for (const double power : {3.0, 6.0}) {
    CAPTURE(power);
    TriangleSoup soup = shapes::terrain(60, 12, 4);
    double side = 0;
    for (const Vec3& p : soup.positions) side = std::max({side, p.x, p.y});
    for (Vec3& p : soup.positions) {
      p.x = side * std::pow(p.x / side, power);
      p.y = side * std::pow(p.y / side, power);
      p.z *= std::min(p.x, p.y) / side;
    }
    const Surface surface(soup);
    for (const std::uint32_t from : {0U, 1830U, 3599U}) {
      if (fixtures::kSanitized && from != 1830) continue;
      CAPTURE(from);
      const std::vector<Source> source{{surface.at(from), 0}};
      const Field truth = surface.field_by(Method::exact, source);
      const Errors off = errors_from(back_traced(surface, source), truth);
      MESSAGE("mean ", off.mean, ", above ", off.above, ", below ", off.below);
      CHECK(off.mean <= 2e-4);
      CHECK(off.above <= 1e-2);
      CHECK(off.below >= -1e-2);
    }
  }
}

// Traces over 48 faces come to no vertex near the straight way there: by them the bound
// would be up to 13 % off.
TEST_CASE("AnUpperBoundOnSliversIsNearToo") {
  TriangleSoup soup;
  constexpr std::uint32_t kAround = 400;
  constexpr std::uint32_t kAlong = 8;
  for (std::uint32_t j = 0; j < kAlong; ++j) {
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      soup.positions.push_back({std::cos(angle), std::sin(angle), 0.5 * j});
      const std::uint32_t a = j * kAround + i;
      const std::uint32_t b = j * kAround + (i + 1) % kAround;
      if (j + 1 == kAlong) continue;
      soup.faces.push_back({a, b, b + kAround});
      soup.faces.push_back({a, b + kAround, a + kAround});
    }
  }
  const Surface surface(soup);
  const std::vector<Source> source{{surface.at(17), 0}};
  const Field truth = surface.field_by(Method::exact, source);
  const Errors upper = errors_from(back_traced(surface, source, Bound::upper), truth);
  CHECK(upper.below >= -1e-12);
  CHECK(upper.above <= 1.3e-7);  // of a float, rounded up
  CHECK(errors_from(back_traced(surface, source), truth).mean <= 1e-4);
}

// The promise of Bound::upper, on everything that is awkward about surfaces; and what
// the other variant has over the paper's front there.
TEST_CASE("AnUpperBoundIsNeverBelowTheTrueDistance") {
  double worst = 0;
  double paper_sum = 0;
  double either_sum = 0;
  for (std::uint32_t number = 0; number < 300; ++number) {
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    SurfacePoint source = surface.at(random.vertex());
    if (number % 3 == 1) {
      source = surface.on(random.below(random.face_count()),
                          {random.unit() + 0.01, random.unit() + 0.01, random.unit() + 0.01});
    } else if (number % 3 == 2) {
      source = surface.on(random.below(random.face_count()),
                          {random.unit() + 0.01, 0, random.unit() + 0.01});
    }
    const Field truth = surface.field_by(Method::exact, {Source{source, 0}});
    const Errors off = errors_from(back_traced(surface, {{source, 0}}, Bound::upper), truth);
    CHECK(off.below >= -1e-9);
    worst = std::min(worst, off.below);
    // And the other variant reaches the same vertices, with distances near them.
    const Errors paper = errors_from(surface.field({{source, 0}}), truth);
    const Errors either = errors_from(back_traced(surface, {{source, 0}}), truth);
    paper_sum += paper.mean;
    either_sum += either.mean;
  }
  MESSAGE("below the true distance by at most ", -worst);
  MESSAGE("mean errors ", either_sum / 300, ", the paper's ", paper_sum / 300);
  CHECK(either_sum < paper_sum / 2);
}

TEST_CASE("PathsRunOnTheFacesOfTheMesh") {
  double longer = 0;
  std::size_t count = 0;
  for (const TriangleSoup& soup :
       {shapes::terrain(40, 10, 2), long_and_thin(shapes::terrain(40, 4, 2), 8),
        shapes::shuffled(shapes::torus_knot(80, 8, 0.4), 3)}) {
    const Surface surface(soup);
    const double size = distance(surface.mesh().box().min, surface.mesh().box().max);
    const std::vector<Source> source{{surface.at(5), 0}};
    const Field truth = surface.field_by(Method::exact, source);
    const Field field = back_traced(surface, source);
    CHECK(field.parents.empty());
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); v += 13) {
      CAPTURE(v);
      const auto path = surface.path(field, point_at_vertex(surface.adjacency(), v));
      REQUIRE(path.has_value());
      fixtures::check_is_a_path(surface.adjacency(), *path, size);
      const auto refined = shorten_path(surface.adjacency(), *path, Cancel());
      REQUIRE(refined.has_value());
      if (truth.distance[v] == 0) continue;
      CHECK(refined->length >= truth.distance[v] * (1 - 1e-9));
      CHECK(refined->length <= truth.distance[v] * 1.03);
      longer += refined->length / truth.distance[v] - 1;
      ++count;
    }
  }
  MESSAGE("refined paths are longer than the shortest by ", longer / double(count));
  CHECK(longer / static_cast<double>(count) <= 5e-4);
}

TEST_CASE("ASourceWithAnOffsetAndAWaveOfItsOwn") {
  const Surface surface(shapes::terrain(40, 6, 4));
  const std::vector<Source> both{{surface.at(100), 0.25}, {surface.at(1500), 1}};
  for (const Bound bound : {Bound::none, Bound::upper}) {
    const Field first = back_traced(surface, {both[0]}, bound);
    const Field second = back_traced(surface, {both[1]}, bound);
    const Field field = back_traced(surface, both, bound);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      const double least = std::min(first.distance[v], second.distance[v]);
      CHECK(field.distance[v] == doctest::Approx(least).epsilon(1e-3));
      const std::uint32_t from = first.distance[v] < second.distance[v] ? 0 : 1;
      if (std::abs(first.distance[v] - second.distance[v]) > 0.1) {
        CHECK(field.nearest_source[v] == from);
      }
    }
  }
}

TEST_CASE("WhereAWaveEndsChangesNoValue") {
  const Surface surface(long_and_thin(shapes::terrain(60, 9, 6), 3));
  for (const Bound bound : {Bound::none, Bound::upper}) {
    const std::vector<Source> source{{surface.at(1830), 0.5}};
    const Field whole = back_traced(surface, source, bound);
    for (const double part : {0.1, 0.4, 0.9}) {
      FieldLimits limits;
      limits.max = part * whole.max;
      const Field field = back_traced(surface, source, bound, limits);
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        if (whole.distance[v] <= limits.max) {
          REQUIRE(field.distance[v] == whole.distance[v]);
        } else {
          REQUIRE(field.distance[v] == kUnreached);
        }
      }
    }
    for (const std::uint32_t target : {7U, 900U, 3599U}) {
      const std::vector<std::uint32_t> targets{surface.vertex(target)};
      FieldLimits limits;
      limits.targets = targets;
      const Field field = back_traced(surface, source, bound, limits);
      CHECK(field.distance[targets[0]] == whole.distance[targets[0]]);
      CHECK(field.max == field.distance[targets[0]]);
    }
  }
}

TEST_CASE("AWaveThatIsCancelledEnds") {
  const Surface surface(shapes::terrain(120, 6, 4));
  BackTracedScratch scratch;
  const Source source{surface.at(0), 0};
  const auto cancelled = back_traced_field(surface.adjacency(), {&source, 1}, {}, Bound::none,
                                           nullptr, scratch, Cancel([] { return true; }));
  REQUIRE_FALSE(cancelled.has_value());
  CHECK(cancelled.error().code == ErrorCode::cancelled);
  // What it leaves behind harms nobody.
  const auto field = back_traced_field(surface.adjacency(), {&source, 1}, {}, Bound::none, nullptr,
                                       scratch, Cancel());
  REQUIRE(field.has_value());
  CHECK(field->distance == back_traced(surface, {source}).distance);
}
