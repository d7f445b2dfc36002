// Distances that are held as floats: how they are rounded, and what still holds of fields.
#include "core/field/vertex_distances.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/solve/pair_search.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using geodesic::fixtures::Surface;

namespace {

constexpr double kStep = 0x1p-23;  // of floats, at most this part of them

Field auto_field(const Surface& surface, const std::vector<Source>& sources,
                 Bound bound = Bound::none, const FieldLimits& limits = {}) {
  MethodOptions options;
  options.bound = bound;
  return surface.field_by(Method::back_traced, sources, limits, options);
}

VertexDistances held(const std::vector<double>& values, Bound bound) {
  VertexDistances distances;
  distances.doubles() = values;
  distances.round_to_floats(bound);
  return distances;
}

}  // namespace

TEST_CASE("AFloatIsNextToItsDistanceOrNotBelow") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-37, 38);
  for (int i = 0; i < 100'000; ++i) {
    const double d = std::pow(10, exponent(random));
    const double nearest = as_float(d);
    CHECK(nearest == static_cast<double>(static_cast<float>(d)));
    CHECK(std::abs(nearest - d) <= kStep / 2 * d);
    const double above = as_float(d, Bound::upper);
    CHECK(above == static_cast<double>(static_cast<float>(above)));
    CHECK(above >= d);
    CHECK(above < d * (1 + kStep));
    // What is a float already stays.
    CHECK(as_float(above) == above);
    CHECK(as_float(above, Bound::upper) == above);
  }
  for (const Bound bound : {Bound::none, Bound::upper}) {
    CHECK(as_float(0, bound) == 0);
    CHECK(as_float(kUnreached, bound) == kUnreached);
    // No float is near these.
    for (const double d : {1e-300, 1e-39, 3.5e38, 1e300}) CHECK(as_float(d, bound) == d);
    const double greatest = std::numeric_limits<float>::max();
    CHECK(as_float(greatest, bound) == greatest);
    CHECK(as_float(std::nextafter(greatest, 0), bound) == greatest);
  }
}

TEST_CASE("FloatsTakeHalfOfWhatDoublesDo") {
  const std::vector<double> values{0, 0.1, 1.0 / 3, 7, kUnreached, 1e30};
  for (const Bound bound : {Bound::none, Bound::upper}) {
    VertexDistances distances = held(values, bound);
    CHECK(distances.are_floats());
    CHECK(distances.size() == values.size());
    CHECK(distances.bytes() == values.size() * sizeof(float));
    for (std::size_t v = 0; v < values.size(); ++v) {
      CHECK(distances[v] == as_float(values[v], bound));
      CHECK(distances.values()[v] == distances[v]);
    }
    distances.forget(1);
    CHECK(distances[1] == kUnreached);
    CHECK(distances[2] == as_float(values[2], bound));
  }
}

TEST_CASE("DistancesOutOfTheRangeOfFloatsStayDoublesAllOfThem") {
  for (const double strange : {1e-39, 3.5e38}) {
    VertexDistances distances = held({0, 0.1, strange}, Bound::none);
    CHECK_FALSE(distances.are_floats());
    CHECK(distances.values() == std::vector<double>{0, 0.1, strange});
    distances.forget(1);
    CHECK(distances[1] == kUnreached);
  }
}

TEST_CASE("AutoIsHeldInFloatsAndWhatPromisesMoreInDoubles") {
  const Surface surface(shapes::terrain(40, 6, 3));
  const std::vector<Source> source{{surface.at(0), 0}};
  for (const Bound bound : {Bound::none, Bound::upper}) {
    const Field field = auto_field(surface, source, bound);
    CHECK(field.distance.are_floats());
    CHECK(field.bytes() <= 4 * 1600 + sizeof(Field) + sizeof(Source));
    const std::vector<double> values = field.distance.values();
    CHECK(field.max == *std::max_element(values.begin(), values.end()));
    CHECK(field.distance[field.farthest] == field.max);
  }
  MethodOptions within;
  within.error_at_most = 1e-6;
  CHECK_FALSE(surface.field_by(Method::back_traced, source, {}, within).distance.are_floats());
  CHECK_FALSE(surface.field_by(Method::exact, source).distance.are_floats());
  CHECK_FALSE(surface.field_from(0).distance.are_floats());
}

TEST_CASE("SurfacesAsSmallOrLargeAsNoFloatAreComputedAsWell") {
  const TriangleSoup unit = shapes::terrain(20, 4, 3);
  const Surface usual(unit);
  const Field expected = auto_field(usual, {{usual.at(0), 0}});
  for (const double scale : {0x1p-140, 0x1p140}) {
    TriangleSoup soup = unit;
    for (Vec3& p : soup.positions) p = scale * p;
    const Surface surface(soup);
    const Field field = auto_field(surface, {{surface.at(0), 0}});
    CHECK_FALSE(field.distance.are_floats());
    CHECK(field.reached == 400);
    for (std::uint32_t i = 0; i < 400; ++i) {
      const double d = field.distance[surface.vertex(i)] / scale;
      CHECK(std::abs(d - expected.distance[usual.vertex(i)]) <= kStep * d);
    }
  }
}

// Who asks for all that is as near as a vertex gets that vertex, whichever way it was rounded.
TEST_CASE("WhatIsAsFarAsTheLimitIsWithinIt") {
  const Surface surface(shapes::terrain(24, 5, 3));
  for (const std::vector<Source>& sources :
       {std::vector<Source>{{surface.at(30), 0}},
        std::vector<Source>{{surface.at(30), 0.1}, {surface.at(500), 0}}}) {
    for (const Bound bound : {Bound::none, Bound::upper}) {
      const Field whole = auto_field(surface, sources, bound);
      for (std::uint32_t v = 0; v < whole.distance.size(); v += fixtures::all_or(7U, 49U)) {
        FieldLimits limits;
        limits.max = whole.distance[v];
        const Field part = auto_field(surface, sources, bound, limits);
        CHECK(part.distance[v] == whole.distance[v]);
        CHECK(part.max == limits.max);
        for (std::uint32_t w = 0; w < whole.distance.size(); ++w) {
          const bool is_within = whole.distance[w] <= limits.max;
          CHECK((part.distance[w] == kUnreached) == !is_within);
        }
      }
    }
  }
}

TEST_CASE("APairHasTheDistanceOfTheRoundedField") {
  const Surface surface(shapes::icosphere(5));
  SolveScratch scratch;
  const Source from{surface.at(3), 0};
  for (const Bound bound : {Bound::none, Bound::upper}) {
    MethodOptions options;
    options.bound = bound;
    const Field field = auto_field(surface, {from}, bound);
    for (const std::uint32_t to : {17U, 800U, 5000U, 10'000U}) {
      const auto pair = pair_search(Method::back_traced, options, surface.adjacency(), from,
                                    surface.at(to), PairPath::none, scratch, Cancel());
      REQUIRE(pair);
      CHECK(pair->distance == field.distance[surface.vertex(to)]);
    }
  }
}

// Where many vertices lie on the way, and rounding moves it past them.
TEST_CASE("PathsOverAPlaneStayStraightThoughDistancesAreRounded") {
  const Surface surface(shapes::plane(60, 60));
  const Field field = auto_field(surface, {{surface.at(1830), 0}});
  REQUIRE(field.distance.are_floats());
  const std::span<const Vec3> positions = surface.mesh().positions();
  const Vec3 from = positions[surface.vertex(1830)];
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    const auto path = surface.path(field, point_at_vertex(surface.adjacency(), v));
    REQUIRE(path);
    CHECK(path->length <= distance(from, positions[v]) * (1 + 1e-5));
  }
}
