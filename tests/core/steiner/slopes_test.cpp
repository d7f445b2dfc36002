// What walking on slopes costs: by Tobler's function, by energy and by tables, on inclined planes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "core/field/travel_cost.h"
#include "core/mesh/shapes.h"
#include "core/steiner/steep_ground.h"
#include "tests/core/steiner/cost_fixtures.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::cheapest;
using fixtures::Cost;
using fixtures::cost_of;
using fixtures::costs;
using fixtures::kClose;
using fixtures::Surface;
using fixtures::total;

namespace {

// The plane z = slope * x over a grid, up being z.
TriangleSoup inclined(std::uint32_t side, double slope) {
  TriangleSoup soup = shapes::plane(side, side);
  for (Vec3& p : soup.positions) p.z = slope * p.x;
  return soup;
}

// What a way costs on a plane at best, in however many parts of whatever directions: the convex
// hull of the costs of all directions.
double at_best(const TravelCost& cost, double slope, double dx, double dy) {
  constexpr int kDirections = 1440;
  struct Direction {
    double x, y, cost;
  };
  std::vector<Direction> all;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2 * M_PI * i / kDirections;
    const double x = std::cos(angle);
    const double y = std::sin(angle);
    const double each = cost.of(0, {}, {x, y, slope * x});
    if (each < kUnreached) all.push_back({x, y, each});
  }
  double best = kUnreached;
  for (const Direction& a : all) {
    for (const Direction& b : all) {
      const double turn = a.x * b.y - a.y * b.x;
      if (std::abs(turn) < 1e-9) continue;
      const double of_a = (dx * b.y - dy * b.x) / turn;
      const double of_b = (a.x * dy - a.y * dx) / turn;
      if (of_a < -1e-12 || of_b < -1e-12) continue;
      best = std::min(best, of_a * a.cost + of_b * b.cost);
    }
  }
  return best;
}

}  // namespace

TEST_CASE("OnAGentleSlopeOneWalksStraightAtToblersSpeed") {
  constexpr double kSlope = 0.1;
  const Surface surface(inclined(17, kSlope));
  const Cost cost = cost_of({.rate = TravelCost::Rate::tobler, .up = {0, 0, 1}});
  const std::uint32_t start = 8 * 17 + 8;
  const Field field = costs(surface, {{surface.at(start), 0}}, cost, 7);
  // By hand: 5 km/h up 10 % is 6 exp(-3.5 * 0.15) km/h, down it is 6 exp(-3.5 * 0.05).
  const double metres = 8 * std::hypot(1, kSlope);
  const double up = field.distance[surface.vertex(8 * 17 + 16)];
  const double down = field.distance[surface.vertex(8 * 17)];
  CHECK(up == doctest::Approx(metres / (6 / 3.6 * std::exp(-3.5 * 0.15))));
  CHECK(down == doctest::Approx(metres / (6 / 3.6 * std::exp(-3.5 * 0.05))));
  for (std::uint32_t v = 0; v < 17 * 17; v += 7) {
    const double dx = double(v % 17) - 8;
    const double dy = double(v / 17) - 8;
    const double found = field.distance[surface.vertex(v)];
    CAPTURE(v);
    // The rate has a corner at a slope of -0.05, where the error is as large as the angle.
    CHECK(found <= cost->of(0, {}, {dx, dy, kSlope * dx}) * 1.03);
    CHECK(found >= at_best(*cost, kSlope, dx, dy) * (1 - 1e-4));
    // And back again: what was up is down.
    const auto path = cheapest(surface, surface.at(v), surface.at(start), cost, 3);
    REQUIRE(path);
    CHECK(total(*path, *cost) <= cost->of(0, {}, {-dx, -dy, -kSlope * dx}) * 1.01);
    CHECK(total(*path, *cost) >= at_best(*cost, kSlope, -dx, -dy) * (1 - 1e-4));
  }
}

// What was measured (Minetti et al. 2002, abstract: means of ten persons) the polynomial has within
// twice what these differed by; what it takes up and down where nobody measured goes on from there.
TEST_CASE("EnergyOfWalkingIsAsMeasuredAndGrowsWithTheHeight") {
  const TravelCost cost({.rate = TravelCost::Rate::energy});
  struct Measured {
    double slope, joules, deviation;
  };
  for (const Measured& one : {Measured{-0.45, 3.46, 0.95}, Measured{-0.10, 0.81, 0.37},
                              Measured{0, 1.64, 0.50}, Measured{0.45, 17.33, 1.11}}) {
    CAPTURE(one.slope);
    CHECK(std::abs(cost.rate_at(one.slope) - one.joules) <= 2 * one.deviation);
  }
  for (const double sign : {-1.0, 1.0}) {
    const double of_height = cost.rate_at(sign * 0.45) / std::sin(std::atan(0.45));
    for (const double steep : {0.4500001, 0.6, 1.0, 5.0, 1e9}) {
      CHECK(cost.rate_at(sign * steep) ==
            doctest::Approx(of_height * std::sin(std::atan(steep))).epsilon(1e-6));
    }
    CHECK(cost.rate_at(sign * std::numeric_limits<double>::infinity()) ==
          doctest::Approx(of_height));
  }
  for (double slope = -2; slope < 2; slope += 0.001) CHECK(cost.rate_at(slope) > 0.93);
}

TEST_CASE("TheWayOfLeastEnergyIsBetweenTheBestOfAllAndTheStraightOne") {
  for (const double slope : {0.0, 0.05, 0.1, 0.3, 0.6}) {
    CAPTURE(slope);
    const Surface surface(inclined(13, slope));
    const Cost cost = cost_of({.rate = TravelCost::Rate::energy, .up = {0, 0, 1}});
    const std::uint32_t start = 6 * 13 + 6;
    const Field field = costs(surface, {{surface.at(start), 0}}, cost, 7);
    for (std::uint32_t v = 0; v < 13 * 13; v += 5) {
      CAPTURE(v);
      const double dx = double(v % 13) - 6;
      const double dy = double(v / 13) - 6;
      const double found = field.distance[surface.vertex(v)];
      const double straight = cost->of(0, {}, {dx, dy, slope * dx});
      CHECK(found >= at_best(*cost, slope, dx, dy) * (1 - 1e-4));
      // On steeper planes a way in the graph is off by more.
      if (slope <= 0.1) CHECK(found <= straight * 1.02);
    }
    const auto path = cheapest(surface, surface.at(6 * 13), surface.at(6 * 13 + 12), cost, 7);
    REQUIRE(path);
    CHECK(total(*path, *cost) <= cost->of(0, {}, {12, 0, 12 * slope}) * (1 + kClose));
    CHECK(total(*path, *cost) >= at_best(*cost, slope, 12, 0) * (1 - 1e-4));
  }
}

// Two names of one place are apart by what rounding leaves, upright or not.
TEST_CASE("WhatRoundingLeavesOfASegmentIsNotSteep") {
  for (const TravelCost::Rate rate : {TravelCost::Rate::tobler, TravelCost::Rate::energy}) {
    const TravelCost cost({.rate = rate, .steepest = 0.2, .up = {0, 0, 1}});
    for (const Vec3 place : {Vec3{1, 2, 3}, Vec3{5e6, 4e5, 300}}) {
      Vec3 above = place;
      above.z = std::nextafter(above.z, 1e9);
      CHECK(cost.of(0, place, above) < 1e-8);
      CHECK(cost.of(0, above, place) < 1e-8);
      CHECK(cost.of(0, place, place) == 0);
      CHECK(cost.of(0, place, place + Vec3{0, 0, 0.1}) == kUnreached);
    }
  }
}

// On planes that are not steeper, to go level costs no more above the least than is said, whatever
// the rate.
TEST_CASE("GoingLevelIsNearTheLeastUpToTheSteepestResolvedSlope") {
  std::mt19937 random(fixtures::test_seed());
  const auto fraction = [&] { return random() / 4294967296.0; };
  std::vector<TravelCost::Parts> kinds;
  kinds.push_back({.rate = TravelCost::Rate::tobler});
  kinds.push_back({.rate = TravelCost::Rate::energy});
  for (int i = 0; i < fixtures::all_or(6, 1); ++i) {
    TravelCost::Parts parts{.rate = TravelCost::Rate::table};
    double slope = -1 - fraction();
    for (int k = 0; k < 6; ++k) {
      parts.table.push_back({slope, 0.5 + slope * slope + 0.1 * fraction()});
      slope += 0.1 + 0.6 * fraction();
    }
    kinds.push_back(parts);
  }
  for (TravelCost::Parts parts : kinds) {
    parts.up = {0, 0, 1};
    const Cost cost = cost_of(parts);
    double before = 0;
    for (const std::uint32_t points : {1U, 3U, 7U}) {
      const double limit = steepest_resolved(*cost, points);
      CAPTURE(points);
      CAPTURE(limit);
      CHECK(limit >= before);
      before = limit;
      const double slope = std::min(0.98 * limit, 3.0);
      const Surface surface(inclined(13, slope));
      const std::uint32_t start = 6 * 13 + 6;
      const Field field = costs(surface, {{surface.at(start), 0}}, cost, points);
      for (std::uint32_t row = 0; row < 13; ++row) {
        if (row == 6) continue;
        CAPTURE(row);
        const double best = at_best(*cost, slope, 0, double(row) - 6);
        CHECK(field.distance[surface.vertex(row * 13 + 6)] <= best * (1 + 1.2 * kMostAboveLevel));
      }
    }
    parts.steepest = 0.01;
    CHECK(steepest_resolved(TravelCost(parts), 3) == doctest::Approx(0.08).epsilon(0.03));
  }
  CHECK(steepest_resolved(TravelCost({}), 3) == std::numeric_limits<double>::infinity());
  const Cancel never;
  Poll poll(never);
  CHECK(steep_part(Surface(inclined(7, 0.2)).adjacency(), {0, 0, 1}, 0.3, poll) == 0);
  CHECK(steep_part(Surface(inclined(7, 0.4)).adjacency(), {0, 0, 1}, 0.3, poll) == 1);
}

TEST_CASE("UpASteepSlopeOneZigzags") {
  constexpr double kSlope = 0.7;
  const Surface surface(inclined(13, kSlope));
  const Cost cost = cost_of({.rate = TravelCost::Rate::tobler, .up = {0, 0, 1}});
  const auto from = surface.at(6 * 13);
  const auto to = surface.at(6 * 13 + 12);
  const double straight = cost->of(0, {}, {12, 0, 12 * kSlope});
  const double best = at_best(*cost, kSlope, 12, 0);
  REQUIRE(best < 0.8 * straight);
  const double found = costs(surface, {{from, 0}}, cost, 7).distance[to.vertex];
  CHECK(found >= best * (1 - 1e-4));
  CHECK(found <= best * 1.05);
}

TEST_CASE("WhatIsTooSteepIsNotWalked") {
  constexpr double kSlope = 0.7;
  const Surface surface(inclined(13, kSlope));
  const Cost cost = cost_of({.steepest = 0.4, .up = {0, 0, 1}});
  const auto from = surface.at(6 * 13);
  const auto to = surface.at(6 * 13 + 12);
  // Zigzag at the greatest slope: the rise over its sine.
  const double best = 12 * kSlope / std::sin(std::atan(0.4));
  const double found = costs(surface, {{from, 0}}, cost, 7).distance[to.vertex];
  CHECK(found >= best * (1 - kClose));
  CHECK(found <= best * 1.1);
  const auto path = cheapest(surface, from, to, cost, 7);
  REQUIRE(path);
  for (std::size_t i = 1; i < path->points.size(); ++i) {
    const Vec3 along = path->points[i].position - path->points[i - 1].position;
    CHECK(std::abs(along.z) <= 0.4 * std::hypot(along.x, along.y) * (1 + 1e-6));
  }
  // Level lines alone: nothing above or below is reached.
  const Field level = costs(surface, {{from, 0}}, cost_of({.steepest = 1e-9, .up = {0, 0, 1}}), 3);
  CHECK(level.reached == 13);
}

// Rounding makes every other segment up such ground a little steeper.
TEST_CASE("GroundAsSteepAsMayBeIsWalked") {
  std::mt19937 random(fixtures::test_seed());
  const auto fraction = [&] { return random() / 4294967296.0; };
  constexpr std::uint32_t kSide = 9;
  for (int round = 0; round < 6; ++round) {
    CAPTURE(round);
    const double slope = 0.05 + fraction();
    CAPTURE(slope);
    TriangleSoup soup = inclined(kSide, slope);
    const bool is_far_out = round % 2 == 1;
    if (is_far_out) {
      const Vec3 away{5e6 * fraction(), 5e6 * fraction(), 5e6 * fraction()};
      for (Vec3& p : soup.positions) p = p + away;
    }
    const Surface surface(soup);
    const std::vector<Source> from{{surface.at(4 * kSide), 0}};
    const Field lengths = costs(surface, from, nullptr);
    const Field walked = costs(surface, from, cost_of({.steepest = slope, .up = {0, 0, 1}}));
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CHECK(walked.distance[v] == lengths.distance[v]);
    }
    if (is_far_out) continue;
    // Straight up what is steeper, one does not go.
    const Field round_about =
        costs(surface, from, cost_of({.steepest = slope * (1 - 1e-6), .up = {0, 0, 1}}));
    const std::uint32_t top = surface.vertex(4 * kSide + kSide - 1);
    CHECK(round_about.distance[top] > lengths.distance[top]);
  }
}

TEST_CASE("RatesOfATableAreLinearBetweenItsEntries") {
  const TravelCost cost(
      {.rate = TravelCost::Rate::table, .table = {{-1, 3}, {0, 1}, {0.5, 2}}, .up = {0, 0, 2}});
  CHECK(cost.rate_at(-7) == 3);
  CHECK(cost.rate_at(-1) == 3);
  CHECK(cost.rate_at(-0.5) == doctest::Approx(2));
  CHECK(cost.rate_at(0) == 1);
  CHECK(cost.rate_at(0.25) == doctest::Approx(1.5));
  CHECK(cost.rate_at(0.5) == 2);
  CHECK(cost.rate_at(std::numeric_limits<double>::infinity()) == 2);
  CHECK(cost.of(0, {}, {0, 0, 3}) == 6);  // straight up
  CHECK(cost.of(0, {}, {3, 4, 0}) == 5);
  CHECK(cost.of(0, {1, 1, 1}, {1, 1, 1}) == 0);
}
