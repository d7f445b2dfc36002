// Costs instead of lengths: refraction by Snell's law, and a second Dijkstra.
#include "core/steiner/cheapest_way.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/field/edge_points.h"
#include "core/mesh/shapes.h"
#include "core/steiner/path.h"
#include "core/steiner/steiner.h"
#include "tests/core/steiner/cost_fixtures.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"
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

// Weights by where the middles of faces lie.
std::vector<double> weights_by(const Mesh& mesh, const std::function<double(Vec3)>& weight) {
  std::vector<double> weights;
  for (const Triangle& t : mesh.faces()) {
    const auto p = mesh.positions();
    weights.push_back(weight(1.0 / 3 * (p[t[0]] + p[t[1]] + p[t[2]])));
  }
  return weights;
}

// The least value of a convex function between two bounds.
double least(double low, double high, const std::function<double(double)>& value) {
  for (int i = 0; i < 200; ++i) {
    const double a = low + (high - low) / 3;
    const double b = high - (high - low) / 3;
    (value(a) < value(b) ? high : low) = value(a) < value(b) ? b : a;
  }
  return value((low + high) / 2);
}

// Costs of whoever walks over the same points, each found by looking through all of them; from a
// vertex to every vertex.
std::vector<double> by_hand(const Surface& surface, std::uint32_t source, const TravelCost& cost,
                            std::uint32_t points) {
  const Mesh& mesh = surface.mesh();
  std::vector<Vec3> at(mesh.positions().begin(), mesh.positions().end());
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> first_of;
  std::vector<std::vector<std::uint32_t>> nodes_of;
  for (const Triangle& t : mesh.faces()) {
    auto& nodes = nodes_of.emplace_back(t.begin(), t.end());
    for (int c = 0; c < 3; ++c) {
      const auto [low, high] = std::minmax({t[c], t[(c + 1) % 3]});
      const auto [edge, is_new] =
          first_of.emplace(std::pair{low, high}, static_cast<std::uint32_t>(at.size()));
      for (std::uint32_t i = 1; i <= points; ++i) {
        if (is_new) {
          at.push_back(at[low] + double(i) / (points + 1) * (at[high] - at[low]));
        }
        nodes.push_back(edge->second + i - 1);
      }
    }
  }
  std::vector<double> known(at.size(), kUnreached);
  std::vector<bool> done(at.size(), false);
  known[source] = 0;
  for (;;) {
    std::size_t next = at.size();
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (!done[i] && known[i] < kUnreached && (next == at.size() || known[i] < known[next])) {
        next = i;
      }
    }
    if (next == at.size()) break;
    done[next] = true;
    for (std::uint32_t f = 0; f < nodes_of.size(); ++f) {
      const auto& nodes = nodes_of[f];
      if (std::find(nodes.begin(), nodes.end(), next) == nodes.end()) continue;
      for (const std::uint32_t node : nodes) {
        known[node] = std::min(known[node], known[next] + cost.of(f, at[next], at[node]));
      }
    }
  }
  known.resize(mesh.vertex_count());
  return known;
}

TravelCost::Parts random_parts(fixtures::RandomMesh& random, const Mesh& mesh) {
  TravelCost::Parts parts;
  if (random.unit() < 0.8) {
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
      parts.weights.push_back(std::pow(10.0, 2 * random.unit() - 1));
    }
  }
  const double kind = random.unit();
  if (kind < 0.3) parts.rate = TravelCost::Rate::tobler;
  if (kind > 0.3 && kind < 0.5) parts.rate = TravelCost::Rate::energy;
  if (kind > 0.7) {
    parts.rate = TravelCost::Rate::table;
    double slope = -2;
    for (std::uint32_t i = 0; i <= random.below(5); ++i) {
      parts.table.push_back({slope, 0.1 + 3 * random.unit()});
      slope += 0.01 + random.unit();
    }
  }
  if (random.unit() < 0.3) parts.steepest = 0.2 + 2 * random.unit();
  parts.up = {random.unit() - 0.5, random.unit() - 0.5, random.unit() + 0.1};
  return parts;
}

}  // namespace

TEST_CASE("WaysBetweenTwoHalfPlanesBendBySnellsLaw") {
  fixtures::RandomMesh random(fixtures::test_seed());
  const Surface surface(shapes::plane(21, 21));
  for (int round = 0; round < 5; ++round) {
    const double beyond = std::pow(10.0, 2 * random.unit() - 1);
    CAPTURE(beyond);
    const Cost cost = cost_of(
        {.weights = weights_by(surface.mesh(), [&](Vec3 p) { return p.x < 10 ? 1 : beyond; })});
    const double y0 = random.below(21);
    const double y1 = random.below(21);
    const auto from = surface.at(static_cast<std::uint32_t>(y0) * 21 + 1);
    const auto to = surface.at(static_cast<std::uint32_t>(y1) * 21 + 18);
    // Over a boundary at y, or along it for a while: that is cheaper where the angle is critical.
    const double cheap = std::min(1.0, beyond);
    const double truth = least(0, 20, [&](double y) {
      return least(0, 20, [&](double z) {
        return std::hypot(9, y - y0) + cheap * std::abs(z - y) + beyond * std::hypot(8, y1 - z);
      });
    });
    double before = kUnreached;
    for (const std::uint32_t points : {1U, 3U, 7U}) {
      const double found = costs(surface, {{from, 0}}, cost, points).distance[to.vertex];
      CHECK(found >= truth * (1 - kClose));
      CHECK(found <= before * (1 + kClose));
      // No more than 17 edges across, 20 along and as many diagonals are met, with this spacing.
      CHECK(found <= truth + 57 * std::sqrt(2) / (points + 1) * std::max(1.0, beyond));
      CHECK(found <= truth * (1 + 0.7 / (points + 1) / (points + 1) + 1e-6));
      before = found;
    }
    const auto path = cheapest(surface, from, to, cost);
    REQUIRE(path);
    fixtures::check_is_a_path(surface.adjacency(), *path, 30);
    CHECK(total(*path, *cost) >= truth * (1 - kClose));
    // It is refined where the first graph has it, which may not be where the best one is.
    CHECK(total(*path, *cost) <= truth * 1.01);
  }
}

TEST_CASE("WaysThroughThreeLayersBendTwice") {
  fixtures::RandomMesh random(fixtures::test_seed() + 1);
  const Surface surface(shapes::plane(22, 22));
  const double a = 1 + 2 * random.unit();
  const double b = 1 + 2 * random.unit();
  const double c = 1 + 2 * random.unit();
  const Cost cost = cost_of({.weights = weights_by(surface.mesh(), [&](Vec3 p) {
                               return p.x < 7 ? a : p.x < 14 ? b : c;
                             })});
  const auto from = surface.at(2 * 22);
  const auto to = surface.at(17 * 22 + 21);
  // The least by way of heights on the two boundaries, 1/40 apart, and along these at the lesser
  // weight: above the truth by the square of that.
  constexpr int kHeights = 21 * 40;
  const auto next = [&](const std::vector<double>& known, double across, double side) {
    std::vector<double> then(kHeights + 1, kUnreached);
    for (int y = 0; y <= kHeights; ++y) {
      for (int z = 0; z <= kHeights; ++z) {
        const double step = std::abs(z - y) / 40.0;
        const double way = across > 0 ? across * std::hypot(7, step) : side * step;
        then[z] = std::min(then[z], known[y] + way);
      }
    }
    return then;
  };
  std::vector<double> known(kHeights + 1, kUnreached);
  known[2 * 40] = 0;
  known = next(known, a, 0);
  known = next(known, 0, std::min(a, b));
  known = next(known, b, 0);
  known = next(known, 0, std::min(b, c));
  const double truth = next(known, c, 0)[17 * 40];
  const auto path = cheapest(surface, from, to, cost);
  REQUIRE(path);
  CHECK(total(*path, *cost) <= truth * 1.01);
  CHECK(total(*path, *cost) >= truth * (1 - 1e-4));
}

TEST_CASE("ACheapRoadIsTakenAtTheCriticalAngle") {
  // A row of cheap faces between y = 10 and y = 11; start and end lie below it.
  const Surface surface(shapes::plane(31, 21));
  const Cost cost = cost_of({.weights = weights_by(surface.mesh(), [](Vec3 p) {
                               return p.y > 10 && p.y < 11 ? 0.5 : 1;
                             })});
  const auto from = surface.at(7 * 31);
  const auto to = surface.at(7 * 31 + 30);
  // Along its nearer edge: there at 30 degrees from the normal, where sin = 0.5.
  const double tangent = std::tan(M_PI / 6);
  const double truth = 2 * 3 / std::cos(M_PI / 6) + 0.5 * (30 - 2 * 3 * tangent);
  REQUIRE(truth < 30);
  const auto path = cheapest(surface, from, to, cost);
  REQUIRE(path);
  CHECK(total(*path, *cost) >= truth * (1 - kClose));
  CHECK(total(*path, *cost) <= truth * 1.001);
  // The other way it costs the same.
  const auto back = cheapest(surface, to, from, cost);
  REQUIRE(back);
  CHECK(total(*back, *cost) == doctest::Approx(total(*path, *cost)).epsilon(1e-3));
}

TEST_CASE("WithoutWeightsCostsAreLengths") {
  for (std::uint32_t round = 0; round < 12; ++round) {
    const std::uint32_t number = fixtures::test_seed() + round;
    CAPTURE(number);
    fixtures::RandomMesh random(number);
    const Surface surface(random.soup());
    const double by = std::pow(10.0, 4 * random.unit() - 2);
    const Source source{surface.on(random.below(random.face_count()),
                                   {random.unit() + 0.01, random.unit() + 0.01, random.unit()}),
                        0};
    const Field lengths = costs(surface, {source}, nullptr);
    const Field ones = costs(surface, {source}, cost_of({}));
    const Field scaled =
        costs(surface, {source},
              cost_of({.weights = std::vector<double>(surface.mesh().face_count(), by)}));
    const Field exact = surface.field_by(Method::exact, {source});
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      REQUIRE((lengths.distance[v] == kUnreached) == (ones.distance[v] == kUnreached));
      if (lengths.distance[v] == kUnreached) continue;
      CHECK(ones.distance[v] == lengths.distance[v]);
      CHECK(std::abs(scaled.distance[v] - by * lengths.distance[v]) <=
            kClose * by * (lengths.distance[v] + lengths.max));
      CHECK(ones.distance[v] >= exact.distance[v] * (1 - kClose));
    }
  }
}

TEST_CASE("CostsAreThoseOfASecondDijkstra") {
  for (std::uint32_t round = 0; round < 12; ++round) {
    const std::uint32_t number = fixtures::test_seed() + round;
    CAPTURE(number);
    fixtures::RandomMesh random(number);
    if (random.face_count() > 300) continue;  // the other one is slow
    const Surface surface(random.soup());
    const Cost cost = cost_of(random_parts(random, surface.mesh()));
    const std::uint32_t points = 1 + random.below(2);
    const std::uint32_t start = surface.vertex(random.vertex());
    const Field field =
        costs(surface, {{point_at_vertex(surface.adjacency(), start), 0}}, cost, points);
    const std::vector<double> expected = by_hand(surface, start, *cost, points);
    for (std::uint32_t v = 0; v < expected.size(); ++v) {
      REQUIRE((expected[v] == kUnreached) == (field.distance[v] == kUnreached));
      if (expected[v] == kUnreached) continue;
      CHECK(std::abs(field.distance[v] - expected[v]) <= kClose * (expected[v] + field.max));
    }
  }
}

TEST_CASE("WaysCostNoMoreThanTheFieldSays") {
  for (std::uint32_t round = 0; round < 25; ++round) {
    const std::uint32_t number = fixtures::test_seed() + round;
    CAPTURE(number);
    fixtures::RandomMesh random(number);
    const Surface surface(random.soup());
    const Cost cost = cost_of(random_parts(random, surface.mesh()));
    const auto anywhere = [&] {
      if (random.unit() < 0.3) return surface.at(random.vertex());
      return surface.on(random.below(random.face_count()),
                        {random.unit() + 0.01, random.unit() < 0.3 ? 0 : random.unit(),
                         random.unit() < 0.3 ? 0 : random.unit()});
    };
    const SurfacePoint from = anywhere();
    const Field field = costs(surface, {{from, 0}}, cost);
    const double size = distance(surface.mesh().box().min, surface.mesh().box().max);
    const Cancel never;
    Poll poll(never);
    const CheapestWays ways(surface.adjacency(), field, poll);
    for (int i = 0; i < 4; ++i) {
      const SurfacePoint to = anywhere();
      const double stated = ways.last_step_to(to).cost;
      const auto path = cheapest(surface, from, to, cost, 3, 1e-3);
      REQUIRE(path.has_value() == (stated < kUnreached));
      if (!path) continue;
      fixtures::check_is_a_path(surface.adjacency(), *path, size);
      const double walked = total(*path, *cost);
      CHECK(walked <= stated * (1 + 1e-6) + kClose * field.max);
      CHECK(path->points.front().position == position_of(surface.mesh(), from));
      CHECK(distance(path->points.back().position, position_of(surface.mesh(), to)) <=
            kClose * size);
    }
  }
}

TEST_CASE("MoreWeightIsNeverCheaper") {
  for (std::uint32_t round = 0; round < 12; ++round) {
    const std::uint32_t number = fixtures::test_seed() + round;
    CAPTURE(number);
    fixtures::RandomMesh random(number);
    const Surface surface(random.soup());
    TravelCost::Parts parts = random_parts(random, surface.mesh());
    parts.weights.assign(surface.mesh().face_count(), 1);
    const Source source{surface.at(random.vertex()), 0};
    Field before = costs(surface, {source}, cost_of(parts), 2);
    for (int step = 0; step < 3; ++step) {
      for (double& weight : parts.weights) {
        if (random.unit() < 0.3) weight *= 1 + 5 * random.unit();
      }
      Field after = costs(surface, {source}, cost_of(parts), 2);
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        CHECK(after.distance[v] >= before.distance[v] * (1 - kClose));
      }
      before = std::move(after);
    }
  }
}

TEST_CASE("WeightsAreTheSameBothWaysAndSlopesTurnedOver") {
  for (std::uint32_t round = 0; round < 12; ++round) {
    const std::uint32_t number = fixtures::test_seed() + round;
    CAPTURE(number);
    fixtures::RandomMesh random(number);
    const Surface surface(random.soup());
    TravelCost::Parts there = random_parts(random, surface.mesh());
    TravelCost::Parts back = there;
    back.up = -1 * back.up;
    const auto a = surface.at(random.vertex());
    const auto b = surface.at(random.vertex());
    const double out = costs(surface, {{a, 0}}, cost_of(there)).distance[b.vertex];
    const double home = costs(surface, {{b, 0}}, cost_of(back)).distance[a.vertex];
    REQUIRE((out == kUnreached) == (home == kUnreached));
    if (out < kUnreached) CHECK(std::abs(out - home) <= kClose * out);
    there.rate = TravelCost::Rate::none;
    const double one = costs(surface, {{a, 0}}, cost_of(there)).distance[b.vertex];
    const double other = costs(surface, {{b, 0}}, cost_of(there)).distance[a.vertex];
    if (one < kUnreached) CHECK(std::abs(one - other) <= kClose * one);
  }
}

TEST_CASE("SeveralSourcesWithOffsetsGiveTheCheapest") {
  fixtures::RandomMesh random(fixtures::test_seed());
  const Surface surface(random.soup());
  const Cost cost = cost_of(random_parts(random, surface.mesh()));
  std::vector<Source> sources;
  for (int i = 0; i < 4; ++i) {
    sources.push_back({surface.on(random.below(random.face_count()),
                                  {random.unit() + 0.01, random.unit(), random.unit()}),
                       random.unit()});
  }
  const Field all = costs(surface, sources, cost);
  std::vector<Field> each;
  for (const Source& source : sources) each.push_back(costs(surface, {source}, cost));
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    double cheapest_one = kUnreached;
    for (const Field& one : each) cheapest_one = std::min(cheapest_one, one.distance[v]);
    CHECK(all.distance[v] == cheapest_one);
    if (cheapest_one < kUnreached) {
      CHECK(each[all.nearest_source[v]].distance[v] == cheapest_one);
    }
  }
}

TEST_CASE("CostsAreCancelledAndAskForMemory") {
  const Surface surface(shapes::plane(60, 60));
  const Cost cost = cost_of({.rate = TravelCost::Rate::tobler});
  WavefrontScratch scratch;
  int left = 3;
  const Cancel soon([&] { return --left < 0; });
  const auto stopped = steiner_path(surface.adjacency(), {surface.at(0), 0}, surface.at(3599), {},
                                    scratch, soon, cost);
  REQUIRE_FALSE(stopped.has_value());
  CHECK(stopped.error().code == ErrorCode::cancelled);
  // Some 3,600 vertices and 3 points on each of some 10,600 edges: of each a cost, and what is
  // before it.
  std::uint64_t asked = 0;
  MemoryBudget counting([&](std::uint64_t bytes) -> std::optional<Error> {
    asked += bytes;
    return std::nullopt;
  });
  const std::vector<Source> corner{{surface.at(0), 0}};
  REQUIRE(
      steiner_field(surface.adjacency(), corner, 3, {}, scratch, Cancel({}, {}, &counting), cost));
  CHECK(asked >= 3 * 10'500 * sizeof(double) + (3600 + 3 * 10'500) * sizeof(std::uint32_t));
  MemoryBudget scant([&, left = asked - 1](std::uint64_t bytes) mutable -> std::optional<Error> {
    if (bytes > left) return Error{ErrorCode::too_large, "no room", {}, {}, {}};
    left -= bytes;
    return std::nullopt;
  });
  const auto refused =
      steiner_field(surface.adjacency(), corner, 3, {}, scratch, Cancel({}, {}, &scant), cost);
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().code == ErrorCode::too_large);
}
