#include "core/field/vertex_set.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

#include "core/field/field.h"
#include "core/mesh/shapes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;
using fixtures::test_seed;

TEST_CASE("AVertexSetIsASet") {
  std::mt19937 random(test_seed());
  VertexSet found;
  for (int round = 0; round < 20; ++round) {
    const std::uint32_t count = 1 + random() % 1000;
    found.reset(count);
    std::set<std::uint32_t> wanted;
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < random() % 500; ++i) {
      const std::uint32_t v = random() % count;
      found.insert(v);
      if (wanted.insert(v).second) order.push_back(v);
    }
    CHECK(std::ranges::equal(found.listed(), order));
    std::vector<std::uint32_t> told;
    found.for_each_ascending([&](std::uint32_t v) { told.push_back(v); });
    CHECK(std::ranges::equal(told, wanted));
  }
}

TEST_CASE("WhatIsInsertedMeanwhileIsToldIfItIsInALaterWord") {
  VertexSet set;
  set.reset(300);
  set.insert(70);
  std::vector<std::uint32_t> told;
  set.for_each_ascending([&](std::uint32_t v) {
    told.push_back(v);
    for (const std::uint32_t more : {3U, 71U, 200U}) set.insert(more);
  });
  CHECK(told == std::vector<std::uint32_t>{70, 200});
  CHECK(std::ranges::equal(set.listed(), std::vector<std::uint32_t>{70, 3, 71, 200}));
}

// Distances of a plane are equal by the dozen, and so is the greatest.
TEST_CASE("KeepingWhatIsWithinIsForgettingTheRestAndCounting") {
  std::mt19937 random(test_seed());
  const Surface surface(shapes::plane(21, 21));
  for (int round = 0; round < 30; ++round) {
    const auto from = static_cast<std::uint32_t>(random() % surface.mesh().vertex_count());
    const Field whole = surface.field_by(Method::dijkstra, {{surface.at(from), 0}});
    const double most = round == 0 ? kUnreached : static_cast<double>(random() % 25);
    Field wanted = whole;
    wanted.forget_beyond(most);
    wanted.count_reached();
    Field found = whole;
    std::vector<std::uint32_t> all(surface.mesh().vertex_count());
    for (std::uint32_t v = 0; v < all.size(); ++v) all[v] = v;
    std::shuffle(all.begin(), all.end(), random);
    found.keep_within(most, all);
    CHECK(found.distance == wanted.distance);
    CHECK(found.reached == wanted.reached);
    CHECK(found.max == wanted.max);
    CHECK(found.farthest == wanted.farthest);
    CHECK(found.nearest_source == wanted.nearest_source);
  }
}
